// One path serves all lights: the way through the scene does not depend on them, so each vertex asks every
// light for its share (next-event estimation), and a ray that leaves the scene asks every environment.
// The estimate of light l is a sum over path vertices of
//   throughput x [ f cos L_l(wi) V / pdf_l  w(pdf_l, pdf_bsdf)            (light sampling)
//               or f cos L_l(wi) / pdf_bsdf w(pdf_bsdf, pdf_l) ]           (BSDF sampling)
// with w the power heuristic between that light's own density and the BSDF's: unbiased for each light alone.
#include <pmmintrin.h>
#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>
#include <xmmintrin.h>

#include <atomic>
#include <chrono>
#include <mutex>

#include "renderer/lights.h"
#include "renderer/random_walk.h"
#include "renderer/surface.h"

namespace ohb {
namespace {

constexpr int kTile_px = 16;
constexpr int kCandidates = 4;               // directions of an environment that compete for a shadow ray
constexpr float kLatticeStep = 0.61803399f;  // golden section: a lattice of any size is even
constexpr int kRouletteFromBounce = 2;       // Cycles: the continuation test starts at the third surface

struct TileResult {
  RayCounts rays;
  uint64_t nonfinite = 0;
};

// Everything that one pixel's paths share.
struct PathContext {
  const Scene& scene;
  const LightSet& lights;
  double turn_rad;
  Vec3f turn_x, turn_z;  // the world's X and Z axes in the subject's frame
  int max_bounces;
  bool subsurface;

  Vec3f to_world(Vec3f v) const { return {dot(v, turn_x), v.y, dot(v, turn_z)}; }
  Vec3f to_subject(Vec3f v) const { return v.x * turn_x + Vec3f{0, v.y, 0} + v.z * turn_z; }
};

float fraction_of(float x) {
  return x - std::floor(x);
}

void add(Vec3f contribution, Vec3f& sum, TileResult& tile) {
  if (is_finite(contribution))
    sum += contribution;
  else
    ++tile.nonfinite;
}

/// One shadow ray to one of several directions that the environment suggests, chosen by what each would
/// bring if it is not shadowed (resampled importance sampling, Talbot et al. 2005, equation 6). The
/// candidates are a lattice shifted by u, so that they spread over the light.
template <bool kCutouts>
void sample_environment(const PathContext& c, const EnvironmentLight& light, const SurfacePoint& point,
                        const PrincipledV1& bsdf, Vec3f throughput, Vec2f u, float u_choice, TileResult& tile,
                        Vec3f& radiance) {
  float sum = 0;
  Vec3f chosen_wi, chosen_value;
  float chosen_weight = 0;
  for (int k = 0; k < kCandidates; ++k) {
    const float kf = static_cast<float>(k);
    const LightSample sample = light.sample(fraction_of(u.x + kf / static_cast<float>(kCandidates)),
                                            fraction_of(u.y + kf * kLatticeStep));
    if (!(sample.pdf > 0) || !(max_component(sample.radiance) > 0)) continue;
    const Vec3f wi = c.to_subject(sample.wi);
    const BsdfValue f = bsdf.eval(wi);
    if (!(max_component(f.value) > 0)) continue;
    const Vec3f value =
        throughput * f.value * sample.radiance * (power_heuristic(sample.pdf, f.pdf) / sample.pdf);
    const float weight = mean(value);
    sum += weight;
    // The choice stays uniform after each candidate: one number serves all.
    const float share = weight / sum;
    if (u_choice < share) {
      u_choice /= share;
      chosen_wi = wi;
      chosen_value = value;
      chosen_weight = weight;
    } else {
      u_choice = (u_choice - share) / (1 - share);
    }
  }
  if (!(chosen_weight > 0)) return;
  const Ray ray{ray_origin(c.scene, point.position, point.ng, chosen_wi), chosen_wi};
  const float visible =
      transmittance<kCutouts>(c.scene, ray, std::numeric_limits<float>::infinity(), tile.rays);
  if (visible > 0)
    add(chosen_value * (visible * sum / (chosen_weight * static_cast<float>(kCandidates))), radiance, tile);
}

template <bool kCutouts>
void sample_lights(const PathContext& c, const SurfacePoint& point, const PrincipledV1& bsdf,
                   Vec3f throughput, PathSampler& sampler, TileResult& tile, std::vector<Vec3f>& radiance) {
  // One set of numbers for all lights: each light's image is unbiased by itself.
  const Vec2f u = sampler.next_pair();
  const float u_choice = sampler.random.next();
  for (size_t l = 0; l < c.lights.environments.size(); ++l)
    sample_environment<kCutouts>(c, c.lights.environments[l], point, bsdf, throughput, u, u_choice, tile,
                                 radiance[l]);
  for (size_t i = 0; i < c.lights.points.size(); ++i) {
    const PointLight& light = c.lights.points[i];
    const Vec3f to_light = turn_about_y(light.position_cm, -c.turn_rad) - point.position;
    const float distance_cm = length(to_light);
    if (!(distance_cm > 0)) continue;
    const Vec3f wi = to_light / distance_cm;
    const BsdfValue f = bsdf.eval(wi);
    if (!(max_component(f.value) > 0)) continue;
    const Ray ray{ray_origin(c.scene, point.position, point.ng, wi), wi};
    const float visible = transmittance<kCutouts>(c.scene, ray, distance_cm, tile.rays);
    const float distance_m = distance_cm * 0.01f;
    add(throughput * f.value * (visible * light.intensity / (distance_m * distance_m)),
        radiance[c.lights.environments.size() + i], tile);
  }
}

void add_environments(const PathContext& c, Vec3f direction, float bsdf_pdf, Vec3f throughput,
                      TileResult& tile, std::vector<Vec3f>& radiance) {
  const Vec3f world = c.to_world(direction);
  for (size_t l = 0; l < c.lights.environments.size(); ++l) {
    const EnvironmentLight& light = c.lights.environments[l];
    const EnvironmentValue value = light.at(world);
    add(throughput * value.radiance * power_heuristic(bsdf_pdf, value.pdf), radiance[l], tile);
  }
}

template <bool kCutouts>
void trace_path(const PathContext& c, Ray ray, PathSampler& sampler, TileResult& tile,
                std::vector<Vec3f>& radiance) {
  Vec3f throughput{1, 1, 1};
  float bsdf_pdf = 0;
  bool diffuse_ancestor = false;  // walks are made before the first diffuse bounce only
  for (int bounce = 0;; ++bounce) {
    Hit hit;
    if (!intersect<kCutouts>(c.scene, ray, sampler.random, tile.rays, hit)) {
      // The camera sees no background: it is transparent.
      if (bounce > 0) add_environments(c, ray.direction, bsdf_pdf, throughput, tile, radiance);
      return;
    }
    if (bounce > c.max_bounces) return;
    if (bounce >= kRouletteFromBounce) {
      const float survive = std::fmin(1.0f, std::sqrt(max_component(throughput)));
      if (!(sampler.random.next() < survive)) return;
      throughput *= 1 / survive;
    }
    Vec3f wo = -ray.direction;
    SurfacePoint point = surface_at(c.scene, hit, wo);
    const bool enters = c.subsurface && !diffuse_ancestor && point.texel.sss > cycles::kLeastSubsurface;
    const Vec3f n = cycles::ensure_valid_reflection(point.ng, wo, point.n);
    PrincipledV1 bsdf =
        bsdf_at(point, n, wo, bounce == 0, enters ? DiffuseLobe::kRetroReflection : DiffuseLobe::kWhole);
    if (bsdf.is_black()) return;
    sample_lights<kCutouts>(c, point, bsdf, throughput, sampler, tile, radiance);
    Vec2f u_lobe = sampler.next_pair(), u = sampler.next_pair();
    BsdfSample next = bsdf.sample(u_lobe.x, u.x, u.y);
    if (next.enters) {
      WalkExit exit;
      if (!walk_under_surface<kCutouts>(c.scene, point, hit.triangle, n, u, sampler.random, tile.rays, exit))
        return;
      // The walk's medium has the colour: the lobe's weight is only its share.
      throughput *= exit.weight / next.pdf;
      wo = exit.direction;
      point = surface_at(c.scene, exit.hit, wo);
      bsdf = exit_bsdf_at(point, wo);
      sample_lights<kCutouts>(c, point, bsdf, throughput, sampler, tile, radiance);
      u_lobe = sampler.next_pair(), u = sampler.next_pair();
      next = bsdf.sample(u_lobe.x, u.x, u.y);
    }
    if (!(next.pdf > 0) || !(max_component(next.value) > 0)) return;
    throughput *= next.value / next.pdf;
    bsdf_pdf = next.pdf;
    diffuse_ancestor |= next.is_diffuse;
    ray = {ray_origin(c.scene, point.position, point.ng, next.wi), next.wi};
  }
}

template <bool kCutouts>
TileResult render_tile(const PathContext& c, const ViewCamera& camera, const RenderSettings& settings,
                       const tbb::blocked_range2d<int>& tile_range, std::vector<SampleLight>& images,
                       std::vector<RecordedRay>* record) {
  TileResult tile;
  tile.rays.record = record;
  std::vector<Vec3f> radiance(c.lights.size());
  for (int y = tile_range.rows().begin(); y < tile_range.rows().end(); ++y)
    for (int x = tile_range.cols().begin(); x < tile_range.cols().end(); ++x) {
      std::fill(radiance.begin(), radiance.end(), Vec3f{});
      const uint64_t pixel =
          static_cast<uint64_t>(y) * static_cast<uint64_t>(settings.size_px) + static_cast<uint64_t>(x);
      for (int s = 0; s < settings.spp; ++s) {
        PathSampler sampler(settings.seed, pixel, static_cast<uint32_t>(s));
        const Vec2f jitter = sampler.next_pair();
        const bool centre = s == 0 && settings.first_sample_at_centre;
        const Ray ray = camera.ray(static_cast<float>(x) + (centre ? 0.5f : jitter.x),
                                   static_cast<float>(y) + (centre ? 0.5f : jitter.y));
        trace_path<kCutouts>(c, ray, sampler, tile, radiance);
      }
      for (size_t l = 0; l < radiance.size(); ++l) {
        float* out = images[l].radiance.pixel(x, y);
        const Vec3f mean_radiance = radiance[l] / static_cast<float>(settings.spp);
        out[0] = mean_radiance.x, out[1] = mean_radiance.y, out[2] = mean_radiance.z;
      }
    }
  return tile;
}

}  // namespace

std::vector<SampleLight> render_lights(const Scene& scene, const LightSet& lights, const Camera& camera,
                                       double turn_rad, const RenderSettings& settings,
                                       RenderStatistics* statistics, const PixelsDone& done) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<SampleLight> images;
  for (const EnvironmentLight& light : lights.environments)
    images.push_back({light.name(), Image(settings.size_px, settings.size_px, 3)});
  for (const PointLight& light : lights.points)
    images.push_back({light.name, Image(settings.size_px, settings.size_px, 3)});
  const PathContext context{scene,
                            lights,
                            turn_rad,
                            turn_about_y({1, 0, 0}, -turn_rad),
                            turn_about_y({0, 0, 1}, -turn_rad),
                            settings.max_bounces,
                            settings.subsurface};
  const ViewCamera view(camera, turn_rad, settings.size_px);
  const bool whole = settings.crop.x1 <= settings.crop.x0 || settings.crop.y1 <= settings.crop.y0;
  const PixelBox box = whole ? PixelBox{0, 0, settings.size_px, settings.size_px} : settings.crop;
  std::mutex record_mutex;
  std::atomic<uint64_t> closest_hit{0}, shadow{0}, walks{0}, walk_segments{0}, nonfinite{0};
  tbb::parallel_for(
      tbb::blocked_range2d<int>(box.y0, box.y1, kTile_px, box.x0, box.x1, kTile_px),
      [&](const tbb::blocked_range2d<int>& range) {
        // Embree is slow on denormals; no radiance that small is visible.
        _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
        _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
        std::vector<RecordedRay> recorded;
        std::vector<RecordedRay>* record = statistics && statistics->record ? &recorded : nullptr;
        const TileResult tile = scene.cutout
                                    ? render_tile<true>(context, view, settings, range, images, record)
                                    : render_tile<false>(context, view, settings, range, images, record);
        if (record) {
          const std::lock_guard<std::mutex> lock(record_mutex);
          statistics->record->insert(statistics->record->end(), recorded.begin(), recorded.end());
        }
        closest_hit += tile.rays.closest_hit;
        shadow += tile.rays.shadow;
        walks += tile.rays.walks;
        walk_segments += tile.rays.walk_segments;
        nonfinite += tile.nonfinite;
        if (done) done(range.rows().size() * range.cols().size());
      },
      tbb::simple_partitioner());
  if (statistics) {
    const uint64_t pixels = static_cast<uint64_t>(box.x1 - box.x0) * static_cast<uint64_t>(box.y1 - box.y0);
    statistics->paths += pixels * static_cast<uint64_t>(settings.spp);
    statistics->closest_hit_rays += closest_hit;
    statistics->shadow_rays += shadow;
    statistics->walks += walks;
    statistics->walk_segments += walk_segments;
    statistics->nonfinite += nonfinite;
    statistics->seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  return images;
}

}  // namespace ohb
