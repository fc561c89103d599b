#include "renderer/rounds.h"

#include <pmmintrin.h>
#include <xmmintrin.h>

#include <atomic>
#include <mutex>

#include "renderer/footprint.h"
#include "renderer/parallel.h"

namespace ohb {
namespace {

constexpr int kTile_px = 16;
constexpr uint64_t kPilotSeeds = 0x70696c6f74ull;

template <bool kCutouts, class Bsdf>
TileResult render_tile(const Picture& picture, const PathRange& paths,
                       const tbb::blocked_range2d<int>& tile_range, std::vector<SampleLight>& images,
                       std::vector<RecordedRay>* record) {
  TileResult tile;
  tile.rays.record = record;
  std::vector<Vec3f> radiance(images.size());
  for (int y = tile_range.rows().begin(); y < tile_range.rows().end(); ++y)
    for (int x = tile_range.cols().begin(); x < tile_range.cols().end(); ++x) {
      const size_t pixel = static_cast<size_t>(y) * picture.settings.size_px + x;
      const uint32_t count = paths.count[pixel];
      if (count == 0) continue;
      const uint32_t first = paths.first ? (*paths.first)[pixel] : 0;
      std::fill(radiance.begin(), radiance.end(), Vec3f{});
      for (uint32_t s = first; s < first + count; ++s) {
        PathSampler sampler(paths.seed, pixel, s);
        const Vec2f jitter = sampler.next_pair();
        const bool centre = s == 0 && picture.settings.first_sample_at_centre;
        const Ray ray = picture.view.ray(static_cast<float>(x) + (centre ? 0.5f : jitter.x),
                                         static_cast<float>(y) + (centre ? 0.5f : jitter.y));
        trace_path<kCutouts, Bsdf>(picture.context, ray, sampler, tile, radiance);
      }
      tile.paths += count;
      for (size_t l = 0; l < radiance.size(); ++l) {
        float* out = images[l].radiance.pixel(x, y);
        const Vec3f mean_radiance = radiance[l] / static_cast<float>(count);
        out[0] = mean_radiance.x, out[1] = mean_radiance.y, out[2] = mean_radiance.z;
      }
    }
  return tile;
}

TileResult render_tile(const Picture& picture, const PathRange& paths, const tbb::blocked_range2d<int>& range,
                       std::vector<SampleLight>& images, std::vector<RecordedRay>* record) {
  const bool cutouts = picture.context.scene.cutout != nullptr;
  const auto render = picture.settings.shading == ShadingModel::kV1
                          ? (cutouts ? render_tile<true, PrincipledV1> : render_tile<false, PrincipledV1>)
                          : (cutouts ? render_tile<true, PrincipledV2> : render_tile<false, PrincipledV2>);
  return render(picture, paths, range, images, record);
}

std::vector<SampleLight> black_images(const LightSet& lights, int size_px) {
  std::vector<SampleLight> images;
  for (const EnvironmentLight& light : lights.environments)
    images.push_back({light.name(), Image(size_px, size_px, 3)});
  for (const PointLight& light : lights.points) images.push_back({light.name, Image(size_px, size_px, 3)});
  return images;
}

}  // namespace

Picture::Picture(const Scene& scene, const LightSet& lights, const Camera& camera, double turn_rad,
                 const RenderSettings& render_settings)
    : context{scene,
              lights,
              turn_rad,
              turn_about_y({1, 0, 0}, -turn_rad),
              turn_about_y({0, 0, 1}, -turn_rad),
              render_settings.max_bounces,
              render_settings.subsurface},
      view(camera, turn_rad, render_settings.size_px),
      settings(render_settings),
      box(settings.crop),
      seen(footprint(scene, view, settings.size_px)) {
  if (box.x1 <= box.x0 || box.y1 <= box.y0) box = {0, 0, settings.size_px, settings.size_px};
}

std::vector<uint32_t> Picture::even_budget(int spp) const {
  std::vector<uint32_t> budget(seen.begin(), seen.end());
  for (uint32_t& paths : budget) paths *= static_cast<uint32_t>(spp);
  return budget;
}

std::vector<SampleLight> render_round(const Picture& picture, const PathRange& paths,
                                      RenderStatistics& statistics, const PixelsDone& done) {
  std::vector<SampleLight> images = black_images(picture.context.lights, picture.settings.size_px);
  std::mutex record_mutex;
  std::atomic<uint64_t> path_count{0}, closest_hit{0}, shadow{0}, walks{0}, walk_segments{0}, leaks{0},
      nonfinite{0};
  const PixelBox& box = picture.box;
  parallel_tiles(box.y0, box.y1, box.x0, box.x1, kTile_px, [&](const tbb::blocked_range2d<int>& range) {
    // Embree is slow on denormals; no radiance that small is visible.
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
    std::vector<RecordedRay> recorded;
    std::vector<RecordedRay>* record = statistics.record ? &recorded : nullptr;
    const TileResult tile = render_tile(picture, paths, range, images, record);
    if (record) {
      const std::lock_guard<std::mutex> lock(record_mutex);
      statistics.record->insert(statistics.record->end(), recorded.begin(), recorded.end());
    }
    path_count += tile.paths;
    closest_hit += tile.rays.closest_hit;
    shadow += tile.rays.shadow;
    walks += tile.rays.walks;
    walk_segments += tile.rays.walk_segments;
    leaks += tile.rays.walk_leaks;
    nonfinite += tile.nonfinite;
    if (done) done(range.rows().size() * range.cols().size());
  });
  statistics.paths += path_count;
  statistics.closest_hit_rays += closest_hit;
  statistics.shadow_rays += shadow;
  statistics.walks += walks;
  statistics.walk_segments += walk_segments;
  statistics.walk_leaks += leaks;
  statistics.nonfinite += nonfinite;
  return images;
}

std::vector<std::vector<SampleLight>> render_pilots(const Picture& picture, int images, int spp,
                                                    RenderStatistics& statistics, const PixelsDone& done) {
  const std::vector<uint32_t> budget = picture.even_budget(spp);
  std::vector<std::vector<SampleLight>> pilots;
  for (int k = 0; k < images; ++k) {
    const uint64_t seed = mix_bits(picture.settings.seed ^ (kPilotSeeds + static_cast<uint64_t>(k)));
    pilots.push_back(render_round(picture, {seed, budget}, statistics, done));
  }
  return pilots;
}

}  // namespace ohb
