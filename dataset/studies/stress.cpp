#include "dataset/studies/stress.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "dataset/model/error.h"
#include "dataset/model/progress.h"
#include "dataset/model/sampling.h"
#include "dataset/model/stopwatch.h"
#include "dataset/studies/stress_scenes.h"
#include "renderer/validation/sides.h"

namespace ohb::studies {
namespace {

constexpr int kMaxBounces = 32;
constexpr double kStandardErrors = 3;

double mean_of(const Image& image) {
  double sum = 0;
  for (size_t i = 0; i < image.values.size(); ++i)
    if (static_cast<int>(i % image.channels) < 3) sum += image.values[i];
  return sum / (3.0 * image.width_px * image.height_px);
}

StressSide side_of(const validation::ImageStack& stack) {
  StressSide side;
  side.is_there = true;
  const double n = static_cast<double>(stack.size());
  double squares = 0;
  for (const Image& image : stack) side.mean += mean_of(image) / n;
  for (const Image& image : stack) squares += std::pow(mean_of(image) - side.mean, 2);
  side.standard_error = std::sqrt(squares / (n * (n - 1)));
  return side;
}

validation::CyclesScene cycles_scene(const StressScene& scene, const StressSettings& settings) {
  validation::CyclesScene cycles;
  cycles.model = &scene.model;
  cycles.environment = &scene.environment;
  cycles.camera = scene.camera;
  cycles.size_px = settings.size_px;
  cycles.max_bounces = kMaxBounces;
  cycles.subsurface = scene.subsurface;
  cycles.passes = {{settings.spp, validation::cycles_seeds(settings.seed, settings.seeds), {}, 0}};
  return cycles;
}

void render_here(const StressScene& scene, const StressSettings& settings, StressResult& result) {
  const Stopwatch loading;
  const auto built = renderer::build_scene(scene.model);
  const auto lights = renderer::prepare_lights({scene.environment}, {});
  const double load_s = loading.wall_s();
  renderer::RenderSettings render;
  render.size_px = settings.size_px;
  render.spp = settings.spp;
  render.max_bounces = kMaxBounces;
  render.subsurface = scene.subsurface;
  validation::ImageStack stack;
  renderer::RenderStatistics statistics;
  const Stopwatch watch;
  for (int k = 0; k < settings.seeds; ++k) {
    render.seed = mix_bits(settings.seed + static_cast<uint64_t>(k));
    stack.push_back(
        renderer::render_lights({*built, *lights, scene.camera, 0}, render, &statistics)[0].radiance);
  }
  const double cpu_s = watch.cpu_s();
  for (const Image& image : stack)
    for (const float v : image.values) result.nan_pixels += !std::isfinite(v);
  const double paths = static_cast<double>(std::max<uint64_t>(1, statistics.paths));
  result.ours = side_of(stack);
  result.ours.load_s = load_s;
  result.ours.cpu_us_a_path = 1e6 * cpu_s / paths;
  result.nonfinite_share = static_cast<double>(statistics.nonfinite) / paths;
  result.leaks = static_cast<double>(statistics.walk_leaks) /
                 static_cast<double>(std::max<uint64_t>(1, statistics.walks));
}

StressSide render_in_cycles(const StressScene& scene, const StressSettings& settings, const Blender& blender,
                            const std::filesystem::path& scratch) {
  std::filesystem::create_directories(scratch);
  const validation::CyclesScene cycles = cycles_scene(scene, settings);
  validation::write_cycles_scene(scratch, cycles);
  validation::CyclesRun run = validation::run_cycles(blender, scratch, settings.threads);
  std::filesystem::remove_all(scratch);
  validation::ImageStack stack;
  double cpu_s = 0;
  for (validation::CyclesRender& render : run.passes.at(0)) {
    stack.push_back(std::move(render.rgba));
    cpu_s += render.cpu_s;
  }
  StressSide side = side_of(stack);
  side.load_s = run.load_s;
  side.cpu_us_a_path =
      1e6 * cpu_s /
      (static_cast<double>(settings.size_px) * settings.size_px * settings.spp * settings.seeds);
  return side;
}

/// Empty if the means agree to `tolerance` and three standard errors.
std::string difference(const StressSide& a, const StressSide& b, double tolerance, const char* whole) {
  if (tolerance < 0) return "";
  const double error = kStandardErrors * std::hypot(a.standard_error, b.standard_error);
  if (std::fabs(a.mean - b.mean) <= tolerance * std::fabs(b.mean) + error) return "";
  return fmt::format("{:.5g} of {} (within {:.3g} and {:.3g} of noise)", a.mean / b.mean, whole, tolerance,
                     error / std::fabs(b.mean));
}

void judge(const StressResult& first, StressResult& result) {
  const StressAcceptance& accept = result.point.accept;
  const auto fail = [&](std::string words) {
    if (!words.empty()) result.failures.push_back(std::move(words));
  };
  if (result.nan_pixels > 0) fail(fmt::format("{} pixels are not finite", result.nan_pixels));
  if (!accept.nonfinite && result.nonfinite_share > 0)
    fail(fmt::format("{:.3g} contributions a path were not finite", result.nonfinite_share));
  if (result.cycles.is_there) fail(difference(result.ours, result.cycles, accept.cycles, "Cycles' light"));
  fail(difference(result.ours, first.ours, accept.first, "the first value's light"));
  const double slowdown = result.ours.cpu_us_a_path / first.ours.cpu_us_a_path;
  if (accept.slowdown > 0 && slowdown > accept.slowdown)
    fail(fmt::format("{:.2g} times the time of the first value", slowdown));
  if (accept.leaks >= 0 && result.leaks > accept.leaks)
    fail(fmt::format("{:.3g} of the walks leak", result.leaks));
}

}  // namespace

std::vector<StressCaseResult> run_stress(const std::vector<StressCase>& catalogue,
                                         const StressSettings& settings,
                                         const std::filesystem::path& scratch) {
  std::optional<Blender> blender;
  if (settings.with_cycles) blender = validation::find_blender(settings.blender);
  size_t count = 0;
  for (const StressCase& stress : catalogue) count += stress.points.size();
  Progress progress("stress", count);
  std::vector<StressCaseResult> all;
  for (const StressCase& stress : catalogue) {
    if (!settings.only.empty() && stress.name != settings.only) continue;
    all.push_back({stress, {}});
    for (const StressPoint& point : stress.points) {
      progress.add();
      if (point.heavy && !settings.with_heavy) continue;
      StressResult result;
      result.point = point;
      const StressScene scene = stress_scene(stress.scene, point.at);
      render_here(scene, settings, result);
      if (blender && point.cycles)
        result.cycles = render_in_cycles(scene, settings, *blender, scratch / "scene");
      judge(all.back().results.empty() ? result : all.back().results.front(), result);
      all.back().results.push_back(std::move(result));
    }
  }
  if (all.empty())
    throw InputError("", "--case " + settings.only, "the catalogue has no case of that name",
                     "use a name that it has");
  return all;
}

}  // namespace ohb::studies
