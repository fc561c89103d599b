// How much the cues of a piece count (see piece_cues.h): logistic regressions, fitted by label_robot --fit.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace ohb::labelling {

using BareCues = std::array<float, 4>;
using HangingCues = std::array<float, 5>;
using LeatherCues = std::array<float, 7>;
/// In the order of the cues; the weights are stored by these names.
constexpr std::array<const char*, 4> kBareCueNames = {"one", "lightness", "hue", "texture"};
constexpr std::array<const char*, 5> kHangingCueNames = {"one", "found", "look", "behind", "area"};
constexpr std::array<const char*, 7> kLeatherCueNames = {"one",     "shoe",  "light", "chroma",
                                                         "texture", "print", "brown"};

struct PieceWeights {
  BareCues bare{};        // log odds of skin against cloth
  HangingCues hanging{};  // of hair against a garment
  LeatherCues leather{};  // of leather against fabric
};

/// 1 / (1 + exp(-weights . cues))
template <size_t N>
float probability_of(const std::array<float, N>& weights, const std::array<float, N>& cues) {
  float sum = 0;
  for (size_t i = 0; i < N; ++i) sum += weights[i] * cues[i];
  return 1 / (1 + std::exp(-sum));
}

}  // namespace ohb::labelling
