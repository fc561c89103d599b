// Images of radiance: tiles of pixels, each with its budget of paths.
#include <chrono>

#include "renderer/budget.h"
#include "renderer/rounds.h"

namespace ohb {
namespace {

// Pilots take an eighth of the work; with fewer paths than these they would tell nothing.
constexpr int kPilots = 4, kPilotShare = 8, kLeastAdaptiveSpp = 32;

/// The same number for every pixel that may see something, or what pilots find out; the pilots' own images
/// are not used for anything else, so that the budget does not depend on what it is spent on.
std::vector<uint32_t> budget_of(const Picture& picture, RenderStatistics& statistics) {
  const RenderSettings& settings = picture.settings;
  if (!settings.adaptive || settings.spp < kLeastAdaptiveSpp) return picture.even_budget(settings.spp);
  const int pilot_spp = settings.spp / (kPilotShare * kPilots);
  return adaptive_budget(render_pilots(picture, kPilots, pilot_spp, statistics, nullptr), picture.seen,
                         settings.size_px, settings.spp - kPilots * pilot_spp);
}

}  // namespace

std::vector<SampleLight> render_lights(const Scene& scene, const LightSet& lights, const Camera& camera,
                                       double turn_rad, const RenderSettings& settings,
                                       RenderStatistics* statistics, const PixelsDone& done) {
  const auto start = std::chrono::steady_clock::now();
  const Picture picture(scene, lights, camera, turn_rad, settings);
  RenderStatistics unasked;
  RenderStatistics& counted = statistics ? *statistics : unasked;
  const std::vector<uint32_t> budget = budget_of(picture, counted);
  std::vector<SampleLight> images = render_round(picture, {settings.seed, budget}, counted, done);
  counted.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return images;
}

}  // namespace ohb
