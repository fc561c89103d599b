// Images of radiance: tiles of pixels, each with its budget of paths.
#include <chrono>

#include "renderer/budget.h"
#include "renderer/rounds.h"

namespace ohb {
namespace {

// Pilots take an eighth of the work; with fewer paths than these they would tell nothing.
constexpr int kPilots = 4, kPilotShare = 8, kLeastAdaptiveSpp = 32;
// Of their mean in the picture: about what is best for an eighth of the paths, unstratified. Any number is
// unbiased that does not depend on them.
constexpr float kPilotWeight = 1.0f / 16;

/// Budgets where pilots find the noise. What they cost the picture is given back in part: whatever budget
/// they lead to, the picture's mean is the same, so a fixed mixture of both is unbiased.
std::vector<SampleLight> render_adaptively(const Picture& picture, RenderStatistics& statistics,
                                           const PixelsDone& done) {
  const RenderSettings& settings = picture.settings;
  const int pilot_spp = settings.spp / (kPilotShare * kPilots);
  const Pilots pilots = render_pilots(picture, kPilots, pilot_spp, statistics, nullptr);
  const std::vector<uint32_t> budget = powers_of_two(
      adaptive_budget(pilots, picture.seen, settings.size_px, settings.spp - kPilots * pilot_spp));
  std::vector<SampleLight> images = render_round(picture, {settings.seed, budget}, statistics, done);
  for (size_t l = 0; l < images.size(); ++l) {
    std::vector<float>& values = images[l].radiance.values;
    for (size_t i = 0; i < values.size(); ++i) {
      float sum = 0;
      for (const std::vector<SampleLight>& pilot : pilots.images) sum += pilot[l].radiance.values[i];
      values[i] += kPilotWeight * (sum / kPilots - values[i]);
    }
  }
  return images;
}

}  // namespace

std::vector<SampleLight> render_lights(const Scene& scene, const LightSet& lights, const Camera& camera,
                                       double turn_rad, const RenderSettings& settings,
                                       RenderStatistics* statistics, const PixelsDone& done) {
  const auto start = std::chrono::steady_clock::now();
  const Picture picture(scene, lights, camera, turn_rad, settings);
  RenderStatistics unasked;
  RenderStatistics& counted = statistics ? *statistics : unasked;
  const std::vector<uint32_t> even = picture.even_budget(settings.spp);
  std::vector<SampleLight> images = settings.adaptive && settings.spp >= kLeastAdaptiveSpp
                                        ? render_adaptively(picture, counted, done)
                                        : render_round(picture, {settings.seed, even}, counted, done);
  counted.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return images;
}

}  // namespace ohb
