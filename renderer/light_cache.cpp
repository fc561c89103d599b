#include "renderer/light_cache.h"

#include <numeric>

#include "dataset/model/parallel.h"
#include "renderer/eight.h"
#include "renderer/intersect.h"
#include "renderer/surface.h"

namespace ohb::renderer {
namespace {

constexpr uint64_t kRaySeed = 0x7669736962ull, kLightSeed = 0x6c69676874ull;
constexpr int kCells = DirectionCells::kCount;
constexpr int kLightLog2 = 6;  // directions of an environment, along each axis
constexpr size_t kVerticesAtOnce = 64;

template <class Act>
void each_vertex(size_t count, const Act& act) {
  const size_t blocks = (count + kVerticesAtOnce - 1) / kVerticesAtOnce;
  parallel_for_each(0, static_cast<int>(blocks), [&](int block) {
    const size_t first = kVerticesAtOnce * static_cast<size_t>(block);
    for (size_t v = first; v < std::min(count, first + kVerticesAtOnce); ++v) act(static_cast<uint32_t>(v));
  });
}

/// The triangles around each vertex, without those of no area.
struct Umbrellas {
  std::vector<uint32_t> first, triangles;  // of vertex v: first[v] to first[v + 1]

  explicit Umbrellas(const Scene& scene) : first(scene.positions.size() + 1, 0) {
    const auto each_corner = [&](const auto& act) {
      for (uint32_t t = 0; t < scene.indices.size() / 3; ++t) {
        const Vec3f ng = geometric_normal(scene, t);
        if (!(dot(ng, ng) > 0.5f)) continue;
        for (int c = 0; c < 3; ++c) act(t, scene.indices[3 * size_t{t} + c]);
      }
    };
    each_corner([&](uint32_t, uint32_t v) { ++first[v + 1]; });
    std::partial_sum(first.begin(), first.end(), first.begin());
    triangles.resize(first.back());
    std::vector<uint32_t> next(first.begin(), first.end() - 1);
    each_corner([&](uint32_t t, uint32_t v) { triangles[next[v]++] = t; });
  }
};

/// Asks around one vertex.
class Asker {
 public:
  Asker(const Scene& scene, const Umbrellas& umbrellas, uint32_t vertex)
      : scene_(scene),
        vertex_(vertex),
        around_(&umbrellas.triangles[umbrellas.first[vertex]]),
        count_(umbrellas.first[vertex + 1] - umbrellas.first[vertex]),
        random_(kRaySeed, vertex, 0) {
    for (uint32_t i = 0; i < count_; ++i) ng_.push_back(geometric_normal(scene, around_[i]));
  }

  void means(Vec3f& normal, Vec3f& reflectance) {
    constexpr int kPoints = 16;
    normal = reflectance = {0, 0, 0};
    for (const Vec3f ng : ng_) normal += ng;
    const float squared = dot(normal, normal);
    normal = squared > 0 ? normal / std::sqrt(squared) : ng_[0];
    for (int k = 0; k < kPoints; ++k) {
      const Hit point = point_in(around_[random_index()]);
      const SurfaceTexel texel =
          scene_.sets[scene_.attributes[point.triangle].set].surface(uv_at(scene_, point));
      // One reflection of even light, seen from a random direction. Principled v1 for both models.
      const Vec2f from = random_.next_pair(), to = random_.next_pair();
      const Vec3f n{0, 0, 1}, wo = sample_cosine_hemisphere(from.x, from.y);
      const PrincipledV1 bsdf({texel.albedo, texel.roughness, srgb_to_linear(texel.specular)}, {n, n, n, wo},
                              false);
      const BsdfSample reflected = bsdf.sample(random_.next(), to.x, to.y);
      const Vec3f share = reflected.value / std::max(reflected.pdf, 1e-6f);
      if (is_finite(share)) reflectance += share / kPoints;
    }
  }

  /// A ray of the cell.
  Ray ray(int cell) {
    const Vec2f place = random_.next_pair();
    const Vec3f direction = DirectionCells::direction(cell, place.x, place.y);
    const uint32_t from = one_towards(direction);
    return {ray_origin(scene_, position_at(scene_, point_in(around_[from])), ng_[from], direction),
            direction};
  }
  /// What eight rays meet.
  void meet(const Ray* rays, Found* found) {
    if (!scene_.cutout)
      closest_opaque(
          scene_, 8, [&](int i) -> const Ray& { return rays[i]; }, false, counts_, found);
    else
      for (int i = 0; i < 8; ++i)
        found[i].is_hit = intersect<true>(scene_, rays[i], random_, counts_, found[i].hit);
  }
  /// Whether they meet anything, which is cheaper.
  void are_free(const Ray* rays, bool* is_free) {
    WaitingLight waiting[8];
    float shares[8];
    for (int i = 0; i < 8; ++i) waiting[i] = {rays[i], std::numeric_limits<float>::infinity(), {}, 0};
    if (scene_.cutout)
      transmittances<true>(scene_, waiting, 8, counts_, shares);
    else
      transmittances<false>(scene_, waiting, 8, counts_, shares);
    for (int i = 0; i < 8; ++i) is_free[i] = random_.next() < shares[i];
  }

 private:
  /// One that the direction leaves from the front, if there is one: points of the others do not ask for it,
  /// or the surface would shade itself along its edges.
  uint32_t one_towards(Vec3f direction) {
    const uint32_t begin = random_index();
    for (uint32_t k = begin; k < begin + count_; ++k) {
      const uint32_t i = k < count_ ? k : k - count_;
      if (dot(ng_[i], direction) > 0) return i;
    }
    return begin;
  }
  uint32_t random_index() {
    return std::min(static_cast<uint32_t>(random_.next() * static_cast<float>(count_)), count_ - 1);
  }
  /// A point of the half of the triangle's edges at the vertex.
  Hit point_in(uint32_t triangle) {
    float a = random_.next(), b = random_.next();
    if (a + b > 1) a = 1 - a, b = 1 - b;
    a *= 0.5f, b *= 0.5f;
    const uint32_t* corners = &scene_.indices[3 * size_t{triangle}];
    if (corners[0] == vertex_) return {triangle, a, b, 0};
    if (corners[1] == vertex_) return {triangle, 1 - a - b, a, 0};
    return {triangle, a, 1 - a - b, 0};
  }

  const Scene& scene_;
  const uint32_t vertex_;
  const uint32_t* around_;
  const uint32_t count_;
  std::vector<Vec3f> ng_;
  Random random_;
  RayCounts counts_;
};

uint32_t nearest_corner(const Scene& scene, const Hit& hit) {
  const float w = 1 - hit.u - hit.v;
  const int corner = hit.u > w ? (hit.v > hit.u ? 2 : 1) : hit.v > w ? 2 : 0;
  return scene.indices[3 * size_t{hit.triangle} + corner];
}

/// What an environment sends from each cell, as eights of cells: radiance times solid angle, and the unit
/// direction that it comes from on average.
struct CellFlux {
  std::vector<Float8> rgb[3];
  std::vector<Vec3f8> direction;

  CellFlux(const EnvironmentLight& light, double turn_rad) {
    std::vector<Vec3f> sums(kCells), directions(kCells);
    LightPool pool;
    pool.fill(light, turn_rad, kLightLog2, kLightLog2, kLightSeed, true);
    for (const LightCandidates& group : pool.groups())
      for (int k = 0; k < LightCandidates::kCount; ++k) {
        if (!(group.pdf[k] > 0)) continue;
        const Vec3f flux = Vec3f{group.red[k], group.green[k], group.blue[k]} / (group.pdf[k] * kDirections);
        sums[group.cell[k]] += flux;
        directions[group.cell[k]] += mean(flux) * Vec3f{group.wi_x[k], group.wi_y[k], group.wi_z[k]};
      }
    for (int cell = 0; cell < kCells; ++cell) {
      const float size = length(directions[cell]);
      directions[cell] = size > 0 ? directions[cell] / size : DirectionCells::direction(cell, 0.5f, 0.5f);
    }
    for (int first = 0; first < kCells; first += 8) {
      const auto lanes = [&](const std::vector<Vec3f>& values, int axis) {
        return Float8([&](auto k) { return values[static_cast<size_t>(first + int{k})][axis]; });
      };
      for (int c = 0; c < 3; ++c) rgb[c].push_back(lanes(sums, c));
      direction.push_back({lanes(directions, 0), lanes(directions, 1), lanes(directions, 2)});
    }
  }

 private:
  static constexpr float kDirections = 1 << 2 * kLightLog2;
};

/// The bits of each byte as 0 and 1.
std::vector<Float8> lanes_of_bytes() {
  std::vector<Float8> lanes(256);
  for (int byte = 0; byte < 256; ++byte)
    lanes[byte] = Float8([&](auto k) { return byte >> int{k} & 1 ? 1.0f : 0.0f; });
  return lanes;
}

Float4 padded(Vec3f v) {
  return Float4([&](auto k) { return int{k} < 3 ? v[int{k}] : 0.0f; });
}

/// Factor from the sum of some bounces to that of all, if each is as much of the one before as the last two.
Vec3f further_bounces(Vec3f sum, Vec3f before, Vec3f last) {
  constexpr float kLargestRatio = 0.9f;
  Vec3f factor{1, 1, 1};
  for (int c = 0; c < 3; ++c) {
    const float ratio = before[c] > 0 ? std::clamp(last[c] / before[c], 0.0f, kLargestRatio) : 0.0f;
    if (sum[c] > 0) factor[c] += last[c] / sum[c] * ratio / (1 - ratio);
  }
  return factor;
}

}  // namespace

VisibilityCache::VisibilityCache(const Scene& scene) {
  const size_t count = scene.positions.size();
  free.resize(count), met.resize(count), normal.resize(count), reflectance.resize(count);
  const Umbrellas umbrellas(scene);
  each_vertex(count, [&](uint32_t v) {
    free[v].words.fill(~uint64_t{0}), met[v].fill(kNothing);
    if (umbrellas.first[v] == umbrellas.first[v + 1]) return;
    Asker asker(scene, umbrellas, v);
    asker.means(normal[v], reflectance[v]);
    const auto block = [&](int cell) {
      free[v].words[static_cast<size_t>(cell) / 64] &= ~(uint64_t{1} << (cell % 64));
    };
    for (int first = 0; first < kCells; first += 8 * kMetStride) {
      Ray rays[8];
      for (int shift = 0; shift < kMetStride; ++shift) {
        const auto cell_of = [&](int i) { return first + shift + kMetStride * i; };
        for (int i = 0; i < 8; ++i) rays[i] = asker.ray(cell_of(i));
        if (shift > 0) {
          bool is_free[8];
          asker.are_free(rays, is_free);
          for (int i = 0; i < 8; ++i)
            if (!is_free[i]) block(cell_of(i));
          continue;
        }
        Found found[8];
        asker.meet(rays, found);
        for (int i = 0; i < 8; ++i) {
          if (!found[i].is_hit) continue;
          block(cell_of(i));
          const Hit& hit = found[i].hit;
          const bool is_back = dot(geometric_normal(scene, hit.triangle), rays[i].direction) > 0;
          met[v][static_cast<size_t>(cell_of(i) / kMetStride)] = 2 * nearest_corner(scene, hit) + is_back;
        }
      }
    }
  });
}

namespace {

/// What a point light makes on the side of a vertex that it shines on.
struct SideIrradiance {
  float value = 0;
  bool is_behind = false;
};

SideIrradiance irradiance_of(const PointLight& light, const Scene& scene, uint32_t vertex, Vec3f n,
                             double turn_rad) {
  const Vec3f to_light = turn_about_y(light.position_cm, -turn_rad) - scene.positions[vertex];
  const float distance_cm = length(to_light);
  if (!(distance_cm > 0)) return {};
  const Vec3f wi = to_light / distance_cm;
  const float distance_m = 0.01f * distance_cm, cosine = dot(n, wi);
  const float irradiance = std::fabs(cosine) * light.intensity / (distance_m * distance_m);
  float share;
  RayCounts counts;
  const WaitingLight waiting{{ray_origin(scene, scene.positions[vertex], n, wi), wi}, distance_cm, {}, 0};
  if (scene.cutout)
    transmittances<true>(scene, &waiting, 1, counts, &share);
  else
    transmittances<false>(scene, &waiting, 1, counts, &share);
  return {share * irradiance, cosine < 0};
}

}  // namespace

std::vector<Vec3f> LightCache::direct(const Scene& scene, const LightSet& lights, double turn_rad) const {
  const size_t count = visibility_.free.size();
  std::vector<CellFlux> fluxes;
  for (const EnvironmentLight& light : lights.environments) fluxes.emplace_back(light, turn_rad);
  const std::vector<Float8> lanes = lanes_of_bytes();
  std::vector<Vec3f> result(2 * count * lights_);
  each_vertex(count, [&](uint32_t v) {
    const Vec3f n = visibility_.normal[v];
    for (size_t l = 0; l < fluxes.size(); ++l) {
      Float8 sums[2][3] = {};
      for (size_t i = 0; i < kCells / 8; ++i) {
        const uint64_t byte = visibility_.free[v].words[i / 8] >> (8 * (i % 8)) & 255;
        const Float8 cosine = dot(n, fluxes[l].direction[i]), zero = 0;
        const Float8 front = lanes[byte] * stdx::max(cosine, zero),
                     back = lanes[byte] * stdx::max(-cosine, zero);
        for (int c = 0; c < 3; ++c) {
          sums[0][c] += front * fluxes[l].rgb[c][i];
          sums[1][c] += back * fluxes[l].rgb[c][i];
        }
      }
      for (int side = 0; side < 2; ++side)
        result[index(v, side != 0, l)] = {stdx::reduce(sums[side][0]), stdx::reduce(sums[side][1]),
                                          stdx::reduce(sums[side][2])};
    }
    for (size_t i = 0; i < lights.points.size(); ++i) {
      const SideIrradiance found = irradiance_of(lights.points[i], scene, v, n, turn_rad);
      result[index(v, found.is_behind, fluxes.size() + i)] = {found.value, found.value, found.value};
    }
  });
  return result;
}

void LightCache::gather() {
  std::vector<float> angles;
  std::vector<Vec3f> centres;
  for (int k = 0; k < VisibilityCache::kMet; ++k) {
    const int cell = k * VisibilityCache::kMetStride;
    angles.push_back(kInvPi * VisibilityCache::kMetStride * DirectionCells::solid_angle(cell));
    centres.push_back(DirectionCells::direction(cell, 0.5f, 0.5f));
  }
  each_vertex(visibility_.free.size(), [&](uint32_t v) {
    std::vector<Float4> of_vertex(2 * lights_, 0);
    float* const blocked = &blocked_[2 * size_t{v}];
    blocked[0] = blocked[1] = 0;
    for (size_t k = 0; k < VisibilityCache::kMet; ++k) {
      const uint32_t met = visibility_.met[v][k];
      if (met == VisibilityCache::kNothing) continue;
      const float cosine = dot(visibility_.normal[v], centres[k]);
      const size_t side = cosine < 0;
      const float weight = angles[k] * std::fabs(cosine);
      blocked[side] += weight;
      for (size_t l = 0; l < lights_; ++l)
        of_vertex[side * lights_ + l] += weight * leaving_[size_t{met} * lights_ + l];
    }
    for (size_t i = 0; i < of_vertex.size(); ++i)
      from_surfaces_[index(v, false, 0) + i] = {of_vertex[i][0], of_vertex[i][1], of_vertex[i][2]};
  });
}

LightCache::LightCache(const VisibilityCache& visibility, const Scene& scene, const LightSet& lights,
                       double turn_rad, int max_bounces)
    : visibility_(visibility), lights_(lights.size()) {
  const size_t count = visibility.free.size();
  const std::vector<Vec3f> direct_light = direct(scene, lights, turn_rad);
  from_surfaces_.resize(direct_light.size()), leaving_.resize(direct_light.size());
  blocked_.resize(2 * count);
  const auto reflect = [&] {
    each_vertex(count, [&](uint32_t v) {
      for (size_t i = index(v, false, 0); i < index(v + 1, false, 0); ++i)
        leaving_[i] = padded(visibility.reflectance[v] * (kInvPi * direct_light[i] + from_surfaces_[i]));
    });
  };
  std::vector<Vec3f> sums(lights_), step(lights_);  // of all vertices; and what the last bounce added
  for (int bounce = 1; bounce <= std::min(max_bounces, kBounces); ++bounce) {
    reflect();
    gather();
    const std::vector<Vec3f> sums_before = sums, step_before = step;
    std::fill(sums.begin(), sums.end(), Vec3f{0, 0, 0});
    for (size_t i = 0; i < from_surfaces_.size(); ++i) sums[i % lights_] += from_surfaces_[i];
    for (size_t l = 0; l < lights_; ++l) step[l] = sums[l] - sums_before[l];
    if (bounce == kBounces && max_bounces > kBounces)
      for (size_t i = 0; i < from_surfaces_.size(); ++i) {
        const size_t l = i % lights_;
        from_surfaces_[i] *= further_bounces(sums[l], step_before[l], step[l]);
      }
  }
  if (max_bounces > kBounces) reflect();
}

}  // namespace ohb::renderer
