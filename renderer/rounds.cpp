#include "renderer/rounds.h"

#include <pmmintrin.h>
#include <xmmintrin.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <utility>

#include "dataset/model/parallel.h"
#include "renderer/footprint.h"
#include "renderer/light_pools.h"
#include "renderer/waves.h"

namespace ohb::renderer {
namespace {

constexpr int kTile_px = 16;
constexpr size_t kPathsAtOnce = 32;  // of a pixel
constexpr float kWorkOfPath = 6;     // besides its rays, in rays (measured)
constexpr uint64_t kPilotSeeds = 0x70696c6f74ull;

/// The guesses of one tile, one a block of pixels; by class, one a class of them.
class Guesses {
 public:
  explicit Guesses(bool by_class)
      : classes_(by_class ? kPixelClasses : 1), guesses_(static_cast<size_t>(kBlocks * kBlocks * classes_)) {}
  ShadowGuess& at(int x, int y) {
    const int block = y % kTile_px / kGuessBlock_px * kBlocks + x % kTile_px / kGuessBlock_px;
    return guesses_[static_cast<size_t>(block * classes_ + (classes_ > 1 ? pixel_class(x, y) : 0))];
  }

 private:
  static_assert(kTile_px % kGuessBlock_px == 0);
  static constexpr int kBlocks = kTile_px / kGuessBlock_px;
  int classes_;
  std::vector<ShadowGuess> guesses_;
};

/// Pixels of one tile: aligned to the image, so that a crop does not change who shares a guess.
struct TileBox {
  PixelBox pixels;
  TilePlace first;
};

/// What the tiles of one round share.
struct Job {
  const Picture& picture;
  const PathRange& paths;
  LightPools& pools;
  std::vector<SampleLight>& images;
  std::vector<float>* work;  // null: not asked for
};

/// The paths of one tile, block of samples after block: those of a block share the candidates of the lights.
template <bool kCutouts, class Bsdf>
class TileRenderer {
 public:
  TileRenderer(const Job& job, const TileBox& box)
      : picture_(job.picture),
        paths_(job.paths),
        pools_(job.pools),
        box_(box),
        work_(job.work),
        lights_(picture_.context.lights.size()),
        guesses_(paths_.by_class) {
    const PixelBox& px = box.pixels;
    sums_.resize(static_cast<size_t>(px.x1 - px.x0) * (px.y1 - px.y0) * lights_);
    samplers_.reserve(kPathsAtOnce);
  }

  void render() {
    uint32_t next = ~0u, end = 0;
    each_pixel([&](int x, int y, Vec3f*) {
      const auto [first, last] = samples_of(x, y);
      if (first < last) next = std::min(next, first), end = std::max(end, last);
    });
    while (next < end) {
      const PoolBlock block = PoolBlock::around(next);
      for (int turn = 0; turn < (paths_.by_class ? kPixelClasses : 1); ++turn) {
        tile.pools = pools_.at(block, turn, box_.first, own_pools_).data();
        each_pixel([&](int x, int y, Vec3f* sum) {
          if (!paths_.by_class || pixel_class(x, y) == turn) trace_pixel(x, y, block, sum);
        });
      }
      next = block.end;
    }
  }

  /// The mean of each pixel's paths, where the picture is wanted.
  void write(std::vector<SampleLight>& images) {
    const PixelBox& wanted = picture_.box;
    each_pixel([&](int x, int y, const Vec3f* sum) {
      if (x < wanted.x0 || x >= wanted.x1 || y < wanted.y0 || y >= wanted.y1) return;
      const auto [first, last] = samples_of(x, y);
      tile.paths += last - first;
      if (work_) (*work_)[pixel_of(x, y)] += kWorkOfPath * static_cast<float>(last - first);
      for (size_t l = 0; l < lights_ && first < last; ++l) {
        float* out = images[l].radiance.pixel(x, y);
        const Vec3f mean_radiance = sum[l] / static_cast<float>(last - first);
        out[0] = mean_radiance.x, out[1] = mean_radiance.y, out[2] = mean_radiance.z;
      }
    });
  }

  Tile tile;

 private:
  size_t pixel_of(int x, int y) const { return static_cast<size_t>(y) * picture_.settings.size_px + x; }

  std::pair<uint32_t, uint32_t> samples_of(int x, int y) const {
    const uint32_t first = paths_.first ? (*paths_.first)[pixel_of(x, y)] : 0;
    return {first, first + paths_.count[pixel_of(x, y)]};
  }

  template <class Act>
  void each_pixel(const Act& act) {
    const PixelBox& px = box_.pixels;
    size_t i = 0;
    for (int y = px.y0; y < px.y1; ++y)
      for (int x = px.x0; x < px.x1; ++x, i += lights_) act(x, y, &sums_[i]);
  }

  /// Those of a pixel's paths that belong to a block.
  void trace_pixel(int x, int y, const PoolBlock& block, Vec3f* radiance) {
    const auto [first, last] = samples_of(x, y);
    const double work_before = tile.rays.work();
    const uint32_t stop = std::min(last, block.end);
    tile.guess = picture_.settings.guess_shadows ? &guesses_.at(x, y) : nullptr;
    tile.radiance = radiance;
    for (uint32_t s = std::max(first, block.first); s < stop;) {
      samplers_.clear();
      for (size_t i = 0; i < kPathsAtOnce && s < stop; ++i, ++s) begin_path(x, y, s);
      trace_paths<kCutouts, Bsdf>(picture_.context, tile);
    }
    if (work_) (*work_)[pixel_of(x, y)] += static_cast<float>(tile.rays.work() - work_before);
  }

  void begin_path(int x, int y, uint32_t s) {
    PathSampler& sampler = samplers_.emplace_back(paths_.seed, pixel_of(x, y), s);
    PathState& path = tile.next.emplace_back(sampler);
    const Vec2f jitter = sampler.next_pair();
    const bool centre = s == 0 && picture_.settings.first_sample_at_centre;
    path.ray = picture_.view.ray(static_cast<float>(x) + (centre ? 0.5f : jitter.x),
                                 static_cast<float>(y) + (centre ? 0.5f : jitter.y));
  }

  const Picture& picture_;
  const PathRange& paths_;
  LightPools& pools_;
  const TileBox& box_;
  std::vector<float>* work_;
  size_t lights_;
  std::vector<LightPool> own_pools_;
  std::vector<Vec3f> sums_;  // one a pixel and light
  Guesses guesses_;
  std::vector<PathSampler> samplers_;  // of the paths at work
};

template <bool kCutouts, class Bsdf>
Tile render_tile(const Job& job, const TileBox& box, std::vector<RecordedRay>* record) {
  TileRenderer<kCutouts, Bsdf> renderer(job, box);
  renderer.tile.rays.record = record;
  renderer.render();
  renderer.write(job.images);
  return std::move(renderer.tile);
}

Tile render_tile(const Job& job, const TileBox& box, std::vector<RecordedRay>* record) {
  const bool cutouts = job.picture.context.scene.cutout != nullptr;
  const auto render = job.picture.settings.shading == ShadingModel::kV1
                          ? (cutouts ? render_tile<true, PrincipledV1> : render_tile<false, PrincipledV1>)
                          : (cutouts ? render_tile<true, PrincipledV2> : render_tile<false, PrincipledV2>);
  return render(job, box, record);
}

std::vector<SampleLight> black_images(const LightSet& lights, int size_px) {
  std::vector<SampleLight> images;
  for (const EnvironmentLight& light : lights.environments)
    images.push_back({light.name(), Image(size_px, size_px, 3)});
  for (const PointLight& light : lights.points) images.push_back({light.name, Image(size_px, size_px, 3)});
  return images;
}

/// The box with all pixels that share a guess with one of its own.
PixelBox whole_blocks(const PixelBox& box, int size_px) {
  const auto up = [&](int px) {
    return std::min(size_px, (px + kGuessBlock_px - 1) / kGuessBlock_px * kGuessBlock_px);
  };
  return {box.x0 / kGuessBlock_px * kGuessBlock_px, box.y0 / kGuessBlock_px * kGuessBlock_px, up(box.x1),
          up(box.y1)};
}

/// Those of most paths first: the last tiles to end are then short ones, and no thread waits long for
/// another.
std::vector<TileBox> tiles_of(const PixelBox& box, const std::vector<uint32_t>& paths, int size_px) {
  std::vector<TileBox> tiles;
  for (int y = box.y0 / kTile_px * kTile_px; y < box.y1; y += kTile_px)
    for (int x = box.x0 / kTile_px * kTile_px; x < box.x1; x += kTile_px)
      tiles.push_back({{std::max(x, box.x0), std::max(y, box.y0), std::min(x + kTile_px, box.x1),
                        std::min(y + kTile_px, box.y1)},
                       {x, y}});
  const auto paths_in = [&](const PixelBox& px) {
    uint64_t sum = 0;
    for (int y = px.y0; y < px.y1; ++y)
      for (int x = px.x0; x < px.x1; ++x) sum += paths[static_cast<size_t>(y) * size_px + x];
    return sum;
  };
  std::stable_sort(tiles.begin(), tiles.end(), [&](const TileBox& a, const TileBox& b) {
    return paths_in(a.pixels) > paths_in(b.pixels);
  });
  return tiles;
}

/// Adds what tiles did, one at a time.
struct TileSums {
  std::mutex mutex;
  void add(const Tile& tile, const std::vector<RecordedRay>& recorded, RenderStatistics& statistics) {
    const std::lock_guard<std::mutex> lock(mutex);
    if (statistics.record)
      statistics.record->insert(statistics.record->end(), recorded.begin(), recorded.end());
    statistics.paths += tile.paths;
    statistics.closest_hit_rays += tile.rays.closest_hit;
    statistics.shadow_rays += tile.rays.shadow;
    statistics.walks += tile.rays.walks;
    statistics.walk_segments += tile.rays.walk_segments;
    statistics.walk_leaks += tile.rays.walk_leaks;
    statistics.nonfinite += tile.nonfinite;
  }
};

}  // namespace

Picture::Picture(const LitView& seen_view, const RenderSettings& render_settings)
    : context{seen_view.scene,
              seen_view.lights,
              seen_view.turn_rad,
              turn_about_y({1, 0, 0}, -seen_view.turn_rad),
              turn_about_y({0, 0, 1}, -seen_view.turn_rad),
              render_settings.max_bounces,
              render_settings.ends_at_rough_surfaces,
              render_settings.subsurface},
      view(seen_view.camera, seen_view.turn_rad, render_settings.size_px),
      settings(render_settings),
      box(settings.crop),
      seen(footprint(context.scene, view, settings.size_px)) {
  if (box.x1 <= box.x0 || box.y1 <= box.y0) box = {0, 0, settings.size_px, settings.size_px};
}

std::vector<uint32_t> Picture::even_budget(int spp) const {
  std::vector<uint32_t> budget(seen.begin(), seen.end());
  for (uint32_t& paths : budget) paths *= static_cast<uint32_t>(spp);
  return budget;
}

std::vector<SampleLight> render_round(const Picture& picture, const PathRange& paths,
                                      RenderStatistics& statistics, const PixelsDone& done,
                                      std::vector<float>* work) {
  std::vector<SampleLight> images = black_images(picture.context.lights, picture.settings.size_px);
  LightPools pools(picture.context.lights, picture.context.turn_rad, paths.seed,
                   picture.settings.guess_shadows);
  const Job job{picture, paths, pools, images, work};
  TileSums sums;
  const std::vector<TileBox> tiles =
      tiles_of(whole_blocks(picture.box, picture.settings.size_px), paths.count, picture.settings.size_px);
  std::atomic<size_t> next{0};
  parallel_for_each(0, static_cast<int>(tiles.size()), [&](int) {
    const size_t t = next++;
    // Embree is slow on denormals; no radiance that small is visible.
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
    std::vector<RecordedRay> recorded;
    std::vector<RecordedRay>* record = statistics.record ? &recorded : nullptr;
    const Tile tile = render_tile(job, tiles[t], record);
    sums.add(tile, recorded, statistics);
    const PixelBox& px = tiles[t].pixels;
    if (done) done(static_cast<size_t>(px.x1 - px.x0) * (px.y1 - px.y0));
  });
  return images;
}

Pilots render_pilots(const Picture& picture, int images, int spp, RenderStatistics& statistics,
                     const PixelsDone& done) {
  const std::vector<uint32_t> budget = picture.even_budget(spp);
  Pilots pilots;
  pilots.work.assign(budget.size(), 0);
  for (int k = 0; k < images; ++k) {
    const uint64_t seed =
        mix_bits(mix_bits(picture.settings.seed) ^ (kPilotSeeds + static_cast<uint64_t>(k)));
    pilots.images.push_back(render_round(picture, {seed, budget}, statistics, done, &pilots.work));
  }
  return pilots;
}

}  // namespace ohb::renderer
