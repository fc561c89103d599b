#include "dataset/people/atlas.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>

#include "dataset/model/mesh_topology.h"

namespace ohb::people {
namespace {

constexpr float kGutter_px = 3;

struct Chart {
  std::vector<uint32_t> faces;  // of the atlas
  std::vector<uint32_t> uvs;    // of the atlas: its corners', each once
  float scale = 0;              // cm a unit of UV, times its weight
  Vec2f size;                   // of the turned chart, cm
};

/// One chart after the other out of faces that share an edge in space and in UV.
class ChartFinder {
 public:
  ChartFinder(const Person& person, Atlas& atlas) : person_(person), atlas_(atlas) {}

  std::vector<Chart> find() {
    for (uint32_t part = 0; part < person_.parts.size(); ++part) {
      if (person_.parts[part].kind == PartKind::kBrows) continue;
      for (const uint32_t face : person_.parts[part].faces) atlas_.faces.push_back({part, face, 0});
    }
    if (atlas_.faces.empty()) throw std::logic_error("a person without faces");
    std::vector<uint32_t> chart_of;
    const uint32_t count = join_faces(chart_of);
    std::vector<Chart> charts(count);
    for (uint32_t f = 0; f < atlas_.faces.size(); ++f) charts[chart_of[f]].faces.push_back(f);
    for (Chart& chart : charts) measure(chart);
    return charts;
  }

 private:
  const Scan& mesh_of(const AtlasFace& face) const { return *person_.parts[face.part].mesh; }

  uint32_t join_faces(std::vector<uint32_t>& chart_of) const {
    DisjointSets sets(atlas_.faces.size());
    std::map<std::array<uint64_t, 3>, uint32_t> edges;
    for (uint32_t f = 0; f < atlas_.faces.size(); ++f) {
      const AtlasFace& face = atlas_.faces[f];
      const Scan& mesh = mesh_of(face);
      const uint32_t begin = mesh.face_begin[face.face], count = mesh.face_begin[face.face + 1] - begin;
      for (uint32_t k = 0; k < count; ++k) {
        Corner a = mesh.corners[begin + k], b = mesh.corners[begin + (k + 1) % count];
        if (b.position < a.position) std::swap(a, b);
        const std::array<uint64_t, 3> key{face.part, uint64_t{a.position} << 32 | b.position,
                                          uint64_t{a.uv} << 32 | b.uv};
        const auto known = edges.emplace(key, f);
        if (!known.second) sets.join(f, known.first->second);
      }
    }
    return sets.number(chart_of);
  }

  /// Gives the chart its UVs (as the asset has them), and its scale.
  void measure(Chart& chart) {
    std::map<uint32_t, uint32_t> own;  // the asset's uv to the atlas's
    float area_cm2 = 0, area_uv = 0, weighted = 0;
    for (const uint32_t f : chart.faces) {
      AtlasFace& face = atlas_.faces[f];
      const Part& part = person_.parts[face.part];
      const Scan& mesh = *part.mesh;
      const uint32_t begin = mesh.face_begin[face.face], end = mesh.face_begin[face.face + 1];
      face.first_corner = static_cast<uint32_t>(atlas_.corner_uv.size());
      for (uint32_t c = begin; c < end; ++c) {
        const auto known = own.emplace(mesh.corners[c].uv, static_cast<uint32_t>(atlas_.uvs.size()));
        if (known.second) {
          atlas_.uvs.push_back(mesh.uvs[mesh.corners[c].uv]);
          chart.uvs.push_back(known.first->second);
        }
        atlas_.corner_uv.push_back(known.first->second);
      }
      float size = 0;
      for (uint32_t c = begin + 1; c + 1 < end; ++c) {
        const Corner a = mesh.corners[begin], b = mesh.corners[c], d = mesh.corners[c + 1];
        size += length(cross(part.posed_cm[b.position] - part.posed_cm[a.position],
                             part.posed_cm[d.position] - part.posed_cm[a.position]));
        area_uv += std::fabs(cross(mesh.uvs[b.uv] - mesh.uvs[a.uv], mesh.uvs[d.uv] - mesh.uvs[a.uv]));
      }
      area_cm2 += size;
      weighted += size * weight_of(part, mesh.corners[begin].position);
    }
    const float weight = area_cm2 > 0 ? weighted / area_cm2 : 1;
    chart.scale = area_uv > 1e-12f ? weight * std::sqrt(area_cm2 / area_uv) : 0;
  }

  float weight_of(const Part& part, uint32_t position) const {
    if (part.kind == PartKind::kEyes) return 2;
    return part.kind == PartKind::kSkin && part.rest_cm[position].y > person_.chin_cm ? 1.6f : 1;
  }

  const Person& person_;
  Atlas& atlas_;
};

/// Turns the chart so that its box is small and lies down, scales it to cm, with its lower left corner at 0.
void turn(Chart& chart, Atlas& atlas) {
  constexpr int kAngles = 18;
  float best_area = INFINITY;
  float cosine = 1, sine = 0;
  const auto box = [&](float c, float s) {
    Vec2f low{INFINITY, INFINITY}, high{-INFINITY, -INFINITY};
    for (const uint32_t uv : chart.uvs) {
      const Vec2f p = atlas.uvs[uv];
      const Vec2f q{c * p.x - s * p.y, s * p.x + c * p.y};
      low = {std::min(low.x, q.x), std::min(low.y, q.y)},
      high = {std::max(high.x, q.x), std::max(high.y, q.y)};
    }
    return std::pair{low, high};
  };
  for (int i = 0; i < kAngles; ++i) {
    const double angle = 1.5707963267948966 * i / kAngles;
    const auto c = static_cast<float>(std::cos(angle)), s = static_cast<float>(std::sin(angle));
    const auto [low, high] = box(c, s);
    const float area = (high.x - low.x) * (high.y - low.y);
    if (area < .999f * best_area) best_area = area, cosine = c, sine = s;
  }
  auto [low, high] = box(cosine, sine);
  if (high.x - low.x < high.y - low.y) {
    const float c = cosine;
    cosine = -sine, sine = c;
    std::tie(low, high) = box(cosine, sine);
  }
  for (const uint32_t uv : chart.uvs) {
    const Vec2f p = atlas.uvs[uv];
    atlas.uvs[uv] = chart.scale * (Vec2f{cosine * p.x - sine * p.y, sine * p.x + cosine * p.y} - low);
  }
  chart.size = chart.scale * (high - low);
}

}  // namespace

std::vector<Vec2f> pack_boxes(const std::vector<Vec2f>& sizes, float square) {
  struct Step {
    float x, y, width;
  };
  std::vector<Step> skyline{{0, 0, square}};
  std::vector<Vec2f> places;
  for (const Vec2f size : sizes) {
    // The lowest place where the box stands on the skyline, of equals the leftmost.
    size_t best = skyline.size();
    float best_y = square;
    for (size_t i = 0; i < skyline.size(); ++i) {
      if (skyline[i].x + size.x > square) break;
      float y = 0;
      for (size_t k = i; k < skyline.size() && skyline[k].x < skyline[i].x + size.x; ++k)
        y = std::max(y, skyline[k].y);
      if (y < best_y && y + size.y <= square) best = i, best_y = y;
    }
    if (best == skyline.size()) return {};
    const float x = skyline[best].x;
    places.push_back({x, best_y});
    const float end = x + size.x;
    size_t after = best;
    while (after < skyline.size() && skyline[after].x + skyline[after].width <= end) ++after;
    std::vector<Step> rest(skyline.begin() + static_cast<std::ptrdiff_t>(after), skyline.end());
    if (!rest.empty()) rest.front().width -= end - rest.front().x, rest.front().x = end;
    skyline.resize(best);
    skyline.push_back({x, best_y + size.y, size.x});
    skyline.insert(skyline.end(), rest.begin(), rest.end());
  }
  return places;
}

Atlas pack_atlas(const Person& person, int size_px) {
  Atlas atlas;
  atlas.size_px = size_px;
  std::vector<Chart> charts = ChartFinder(person, atlas).find();
  for (Chart& chart : charts) turn(chart, atlas);
  std::vector<uint32_t> order(charts.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](uint32_t a, uint32_t b) { return charts[a].size.y > charts[b].size.y; });
  const auto pack = [&](float density) {
    std::vector<Vec2f> sizes;
    sizes.reserve(order.size());
    for (const uint32_t c : order)
      sizes.push_back(density * charts[c].size + Vec2f{2 * kGutter_px, 2 * kGutter_px});
    return pack_boxes(sizes, static_cast<float>(size_px));
  };
  float low = 0, high = 64;  // texels a cm
  for (int i = 0; i < 14; ++i) {
    const float middle = .5f * (low + high);
    (pack(middle).empty() ? high : low) = middle;
  }
  const std::vector<Vec2f> places = pack(low);
  if (places.empty()) throw std::logic_error("more charts than the atlas has room for");
  for (size_t i = 0; i < order.size(); ++i) {
    const Chart& chart = charts[order[i]];
    for (const uint32_t uv : chart.uvs)
      atlas.uvs[uv] = (1 / static_cast<float>(size_px)) *
                      (low * atlas.uvs[uv] + places[i] + Vec2f{kGutter_px, kGutter_px});
    atlas.used_share += low * low * chart.size.x * chart.size.y;
  }
  atlas.used_share /= static_cast<float>(size_px) * static_cast<float>(size_px);
  atlas.px_per_cm = low;
  return atlas;
}

}  // namespace ohb::people
