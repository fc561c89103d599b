#include "dataset/environments/recipe.h"

#include <cmath>
#include <iterator>

#include "dataset/environments/recipe_kinds.h"
#include "dataset/environments/sphere_map.h"

namespace ohb::environments {
namespace {

struct Kind {
  const char* category;
  Painting (*paint)(Random&, int);
};
constexpr Kind kClear{"clear", clear_sky}, kClouds{"clouds", cloudy_sky}, kSunset{"sunset", sunset},
    kOvercast{"overcast", overcast}, kStudio{"studio", studio}, kColoured{"coloured", coloured_lamps},
    kRoom{"room", room_with_windows};
// In an order in which few have much of all.
constexpr Kind kTurn[] = {kClear,  kStudio, kRoom,     kSunset, kColoured,
                          kClouds, kStudio, kOvercast, kRoom,   kColoured};

const Kind& kind_of(uint64_t index) {
  return kTurn[index % std::size(kTurn)];
}

}  // namespace

std::string category_of(uint64_t index) {
  return kind_of(index).category;
}

SynthesisedLight synthesised(uint64_t seed, uint64_t index, int width_px) {
  const Kind& kind = kind_of(index);
  Random random(seed, index, kSynthesisVersion);
  const float mean_luminance = within_ratio(random, 0.35f, 1.2f);
  Painting painting = kind.paint(random, width_px);
  const LightStatistics light = statistics_of(painting.map);
  const double mean = 0.2126 * light.mean[0] + 0.7152 * light.mean[1] + 0.0722 * light.mean[2];
  const auto scale = static_cast<float>(static_cast<double>(mean_luminance) / mean);
  for (float& value : painting.map.values) value *= scale;
  return {std::move(painting.map), kind.category, std::move(painting.words)};
}

}  // namespace ohb::environments
