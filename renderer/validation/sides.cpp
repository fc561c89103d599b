#include "renderer/validation/sides.h"

#include <algorithm>
#include <optional>

#include "dataset/model/parallel.h"
#include "dataset/model/sampling.h"
#include "dataset/model/stopwatch.h"

namespace ohb::validation {
namespace {

/// The bar that is shared, or one of its own.
class Bar {
 public:
  Bar(Progress* shared, const char* label, size_t images) {
    if (!shared) own_.emplace(label, images * kStepsOfImage);
    bar_ = shared ? shared : &*own_;
  }
  Progress& operator*() { return *bar_; }

 private:
  std::optional<Progress> own_;
  Progress* bar_;
};

}  // namespace

size_t image_count(const std::vector<CyclesPass>& passes) {
  size_t count = 0;
  for (const CyclesPass& pass : passes) count += pass.seeds.size();
  return count;
}

CyclesSide render_cycles_side(const CyclesScene& scene, const Blender& blender, int threads,
                              const std::filesystem::path& scratch, Progress* shared) {
  write_cycles_scene(scratch, scene);
  Bar bar(shared, "Cycles", image_count(scene.passes));
  size_t drawn = 0;
  CyclesRun run = run_cycles(blender, scratch, threads, [&](double images) {
    const size_t steps =
        std::min(static_cast<size_t>(images * kStepsOfImage), image_count(scene.passes) * kStepsOfImage);
    if (steps > drawn) (*bar).add(steps - drawn);
    drawn = std::max(drawn, steps);
  });
  CyclesSide side;
  side.settings = std::move(run.settings);
  for (std::vector<CyclesRender>& pass : run.passes) {
    side.passes.emplace_back();
    SideCost cost;
    cost.load_s = run.load_s;
    for (const CyclesRender& render : pass) {
      cost.wall_s += render.wall_s / static_cast<double>(pass.size());
      cost.cpu_s += render.cpu_s / static_cast<double>(pass.size());
    }
    side.pass_costs.push_back(cost);
    for (CyclesRender& render : pass) side.passes.back().push_back(std::move(render.rgba));
  }
  side.cost = side.pass_costs.front();
  return side;
}

OurRenderer::OurRenderer(const CyclesScene& scene) : scene_(scene) {
  const Stopwatch loading;
  built_ = renderer::build_scene(*scene.model);
  std::vector<Environment> environments;
  if (scene.environment) environments.push_back(*scene.environment);
  lights_ = renderer::prepare_lights(environments, scene.points);
  load_s_ = loading.wall_s();
}

renderer::RenderSettings OurRenderer::settings() const {
  renderer::RenderSettings settings;
  settings.size_px = scene_.size_px;
  settings.max_bounces = scene_.max_bounces;
  settings.shading = scene_.shading;
  settings.subsurface = scene_.subsurface;
  settings.first_sample_at_centre = true;
  return settings;
}

Sample OurRenderer::maps() const {
  return renderer::render_maps(*built_, scene_.camera, scene_.turn_rad, settings());
}

ImageStack OurRenderer::render_pass(const CyclesPass& pass, uint64_t seed, std::atomic<uint64_t>& nonfinite,
                                    Progress& progress) const {
  ImageStack stack(pass.seeds.size());
  const auto render_seed = [&](int k) {
    renderer::RenderSettings settings = this->settings();
    settings.spp = pass.spp;
    settings.seed = mix_bits(seed + static_cast<uint64_t>(k));
    renderer::RenderStatistics statistics;
    Image sum(settings.size_px, settings.size_px, 3);
    for (const renderer::PixelBox& box :
         pass.boxes.empty() ? std::vector<renderer::PixelBox>{{}} : pass.boxes) {
      settings.crop = box;
      for (const SampleLight& light : renderer::render_lights(
               {*built_, *lights_, scene_.camera, scene_.turn_rad}, settings, &statistics))
        for (size_t i = 0; i < sum.values.size(); ++i) sum.values[i] += light.radiance.values[i];
    }
    stack[static_cast<size_t>(k)] = std::move(sum);
    nonfinite += statistics.nonfinite;
    progress.add(kStepsOfImage);
  };
  const int count = static_cast<int>(pass.seeds.size());
  if (pass.boxes.empty())
    for (int k = 0; k < count; ++k) render_seed(k);
  else
    parallel_for_each(0, count, render_seed);  // a small box by itself would keep few threads busy
  return stack;
}

OurSide OurRenderer::render(const std::vector<CyclesPass>& passes, uint64_t seed, Progress* shared) const {
  OurSide side;
  Bar bar(shared, "ours", image_count(passes));
  std::atomic<uint64_t> nonfinite{0};
  for (size_t i = 0; i < passes.size(); ++i) {
    const Stopwatch watch;
    side.passes.push_back(render_pass(passes[i], mix_bits(mix_bits(seed) + i), nonfinite, *bar));
    SideCost cost;
    cost.load_s = load_s_;
    cost.wall_s = watch.wall_s() / static_cast<double>(passes[i].seeds.size());
    cost.cpu_s = watch.cpu_s() / static_cast<double>(passes[i].seeds.size());
    side.pass_costs.push_back(cost);
  }
  side.cost = side.pass_costs.front();
  side.nonfinite = nonfinite;
  return side;
}

}  // namespace ohb::validation
