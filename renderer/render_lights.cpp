// Images of radiance: tiles of pixels, each with its budget of paths.
#include <chrono>

#include "renderer/budget.h"
#include "renderer/rounds.h"

namespace ohb::renderer {
namespace {

// A pixel's first paths tell how noisy its neighbours are: up to an eighth of the mean (a quarter below 32),
// in equal parts.
constexpr uint32_t kParts = 4, kBegunShare = 8;
constexpr int kLeastAdaptiveSpp = 16;

/// `mean` of `paths` paths a pixel, and another of `more` paths, which may be 0 in some.
void add_mean(std::vector<SampleLight>& mean, const std::vector<uint32_t>& paths,
              const std::vector<SampleLight>& other, const std::vector<uint32_t>& more) {
  for (size_t l = 0; l < mean.size(); ++l)
    for (size_t i = 0; i < mean[l].radiance.values.size(); ++i) {
      if (more[i / 3] == 0) continue;
      const float share = static_cast<float>(more[i / 3]) / static_cast<float>(paths[i / 3] + more[i / 3]);
      float& value = mean[l].radiance.values[i];
      value += share * (other[l].radiance.values[i] - value);
    }
}

/// Budgets where the first paths find the noise: in the neighbours, so that no pixel's own paths decide how
/// many it gets.
std::vector<SampleLight> render_adaptively(const Picture& picture, RenderStatistics& statistics,
                                           const PixelsDone& done) {
  const RenderSettings& settings = picture.settings;
  uint32_t part_spp = 1;
  while (2 * part_spp * kParts * kBegunShare <= static_cast<uint32_t>(settings.spp)) part_spp *= 2;
  const std::vector<uint32_t> part = picture.even_budget(static_cast<int>(part_spp));
  std::vector<uint32_t> made(part.size(), 0);
  Pilots begun;
  begun.work.assign(part.size(), 0);
  std::vector<SampleLight> images;
  for (uint32_t k = 0; k < kParts; ++k) {
    begun.images.push_back(
        render_round(picture, {settings.seed, part, &made, true}, statistics, nullptr, &begun.work));
    if (k == 0)
      images = begun.images[0];
    else
      add_mean(images, made, begun.images[k], part);
    for (size_t i = 0; i < made.size(); ++i) made[i] += part[i];
  }
  std::vector<uint32_t> more =
      continued_budget(begun, kParts * part_spp, picture.seen, settings.size_px, settings.spp);
  for (size_t i = 0; i < more.size(); ++i) more[i] -= made[i];
  add_mean(images, made, render_round(picture, {settings.seed, more, &made}, statistics, done), more);
  return images;
}

}  // namespace

std::vector<SampleLight> render_lights(const LitView& view, const RenderSettings& settings,
                                       RenderStatistics* statistics, const PixelsDone& done) {
  const auto start = std::chrono::steady_clock::now();
  const Picture picture(view, settings);
  RenderStatistics unasked;
  RenderStatistics& counted = statistics ? *statistics : unasked;
  const std::vector<uint32_t> even = picture.even_budget(settings.spp);
  std::vector<SampleLight> images = settings.adaptive && settings.spp >= kLeastAdaptiveSpp
                                        ? render_adaptively(picture, counted, done)
                                        : render_round(picture, {settings.seed, even}, counted, done);
  counted.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return images;
}

}  // namespace ohb::renderer
