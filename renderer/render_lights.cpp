// Images of radiance: tiles of pixels, each with its budget of paths.
#include <pmmintrin.h>
#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>
#include <xmmintrin.h>

#include <atomic>
#include <chrono>
#include <mutex>

#include "renderer/budget.h"
#include "renderer/footprint.h"
#include "renderer/path_tracer.h"

namespace ohb {
namespace {

constexpr int kTile_px = 16;
// Pilots take an eighth of the work; with fewer paths than these they would tell nothing.
constexpr int kPilots = 4, kPilotShare = 8, kLeastAdaptiveSpp = 32;
constexpr uint64_t kPilotSeeds = 0x70696c6f74ull;

/// One call's scene, lights and view.
struct Picture {
  const PathContext& context;
  const ViewCamera& view;
  const RenderSettings& settings;
  PixelBox box;
};

template <bool kCutouts>
TileResult render_tile(const Picture& picture, uint64_t seed, const std::vector<uint32_t>& budget,
                       const tbb::blocked_range2d<int>& tile_range, std::vector<SampleLight>& images,
                       std::vector<RecordedRay>* record) {
  TileResult tile;
  tile.rays.record = record;
  std::vector<Vec3f> radiance(images.size());
  for (int y = tile_range.rows().begin(); y < tile_range.rows().end(); ++y)
    for (int x = tile_range.cols().begin(); x < tile_range.cols().end(); ++x) {
      const size_t pixel = static_cast<size_t>(y) * picture.settings.size_px + x;
      if (budget[pixel] == 0) continue;
      std::fill(radiance.begin(), radiance.end(), Vec3f{});
      for (uint32_t s = 0; s < budget[pixel]; ++s) {
        PathSampler sampler(seed, pixel, s);
        const Vec2f jitter = sampler.next_pair();
        const bool centre = s == 0 && picture.settings.first_sample_at_centre;
        const Ray ray = picture.view.ray(static_cast<float>(x) + (centre ? 0.5f : jitter.x),
                                         static_cast<float>(y) + (centre ? 0.5f : jitter.y));
        trace_path<kCutouts>(picture.context, ray, sampler, tile, radiance);
      }
      tile.paths += budget[pixel];
      for (size_t l = 0; l < radiance.size(); ++l) {
        float* out = images[l].radiance.pixel(x, y);
        const Vec3f mean_radiance = radiance[l] / static_cast<float>(budget[pixel]);
        out[0] = mean_radiance.x, out[1] = mean_radiance.y, out[2] = mean_radiance.z;
      }
    }
  return tile;
}

std::vector<SampleLight> black_images(const LightSet& lights, int size_px) {
  std::vector<SampleLight> images;
  for (const EnvironmentLight& light : lights.environments)
    images.push_back({light.name(), Image(size_px, size_px, 3)});
  for (const PointLight& light : lights.points) images.push_back({light.name, Image(size_px, size_px, 3)});
  return images;
}

/// Every pixel of the box with its number of paths; 0 leaves it black.
std::vector<SampleLight> render_round(const Picture& picture, uint64_t seed,
                                      const std::vector<uint32_t>& budget, RenderStatistics& statistics,
                                      const PixelsDone& done) {
  const Scene& scene = picture.context.scene;
  std::vector<SampleLight> images = black_images(picture.context.lights, picture.settings.size_px);
  std::mutex record_mutex;
  std::atomic<uint64_t> paths{0}, closest_hit{0}, shadow{0}, walks{0}, walk_segments{0}, nonfinite{0};
  const PixelBox& box = picture.box;
  tbb::parallel_for(
      tbb::blocked_range2d<int>(box.y0, box.y1, kTile_px, box.x0, box.x1, kTile_px),
      [&](const tbb::blocked_range2d<int>& range) {
        // Embree is slow on denormals; no radiance that small is visible.
        _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
        _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
        std::vector<RecordedRay> recorded;
        std::vector<RecordedRay>* record = statistics.record ? &recorded : nullptr;
        const TileResult tile = scene.cutout
                                    ? render_tile<true>(picture, seed, budget, range, images, record)
                                    : render_tile<false>(picture, seed, budget, range, images, record);
        if (record) {
          const std::lock_guard<std::mutex> lock(record_mutex);
          statistics.record->insert(statistics.record->end(), recorded.begin(), recorded.end());
        }
        paths += tile.paths;
        closest_hit += tile.rays.closest_hit;
        shadow += tile.rays.shadow;
        walks += tile.rays.walks;
        walk_segments += tile.rays.walk_segments;
        nonfinite += tile.nonfinite;
        if (done) done(range.rows().size() * range.cols().size());
      },
      tbb::simple_partitioner());
  statistics.paths += paths;
  statistics.closest_hit_rays += closest_hit;
  statistics.shadow_rays += shadow;
  statistics.walks += walks;
  statistics.walk_segments += walk_segments;
  statistics.nonfinite += nonfinite;
  return images;
}

/// The same number for every pixel that may see something, or what pilots find out; the pilots' own images
/// are not used for anything else, so that the budget does not depend on what it is spent on.
std::vector<uint32_t> budget_of(const Picture& picture, RenderStatistics& statistics) {
  const RenderSettings& settings = picture.settings;
  const std::vector<uint8_t> seen = footprint(picture.context.scene, picture.view, settings.size_px);
  const auto even = [&](int spp) {
    std::vector<uint32_t> budget(seen.begin(), seen.end());
    for (uint32_t& paths : budget) paths *= static_cast<uint32_t>(spp);
    return budget;
  };
  if (!settings.adaptive || settings.spp < kLeastAdaptiveSpp) return even(settings.spp);
  const int pilot_spp = settings.spp / (kPilotShare * kPilots);
  std::vector<std::vector<SampleLight>> pilots;
  for (int k = 0; k < kPilots; ++k)
    pilots.push_back(render_round(picture, mix_bits(settings.seed ^ (kPilotSeeds + static_cast<uint64_t>(k))),
                                  even(pilot_spp), statistics, nullptr));
  return adaptive_budget(pilots, seen, settings.size_px, settings.spp - kPilots * pilot_spp);
}

}  // namespace

std::vector<SampleLight> render_lights(const Scene& scene, const LightSet& lights, const Camera& camera,
                                       double turn_rad, const RenderSettings& settings,
                                       RenderStatistics* statistics, const PixelsDone& done) {
  const auto start = std::chrono::steady_clock::now();
  const PathContext context{scene,
                            lights,
                            turn_rad,
                            turn_about_y({1, 0, 0}, -turn_rad),
                            turn_about_y({0, 0, 1}, -turn_rad),
                            settings.max_bounces,
                            settings.subsurface};
  const ViewCamera view(camera, turn_rad, settings.size_px);
  const bool whole = settings.crop.x1 <= settings.crop.x0 || settings.crop.y1 <= settings.crop.y0;
  const Picture picture{context, view, settings,
                        whole ? PixelBox{0, 0, settings.size_px, settings.size_px} : settings.crop};
  RenderStatistics unasked;
  RenderStatistics& counted = statistics ? *statistics : unasked;
  const std::vector<uint32_t> budget = budget_of(picture, counted);
  std::vector<SampleLight> images = render_round(picture, settings.seed, budget, counted, done);
  counted.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return images;
}

}  // namespace ohb
