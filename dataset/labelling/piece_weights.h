// How much the cues of a piece count (see piece_cues.h): logistic regressions, fitted by label_robot --fit.
// Those of leather speak of people half of whose garments are leather; how many really are is stated.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace ohb::labelling {

using BareCues = std::array<float, 5>;
using HangingCues = std::array<float, 5>;
using HeadCues = std::array<float, 7>;
using LeatherCues = std::array<float, 8>;
/// In the order of the cues; the weights are stored by these names.
constexpr std::array<const char*, 5> kBareCueNames = {"one", "lightness", "hue", "texture", "above"};
constexpr std::array<const char*, 5> kHangingCueNames = {"one", "found", "look", "behind", "area"};
constexpr std::array<const char*, 7> kHeadCueNames = {"one",     "found", "chroma", "light",
                                                      "texture", "above", "folded"};
/// The squares: leather is often very dark or very bright, and its grain neither smooth nor coarse.
constexpr std::array<const char*, 8> kLeatherCueNames = {"one",   "light", "chroma",       "texture",
                                                         "print", "brown", "light_square", "texture_square"};

/// How many garments, shoes apart, are leather where nothing else is stated: one in twenty.
constexpr float kLeatherShare = 0.05f;
/// Of shoes: leather and cloth ones look alike, and no cue tells them.
constexpr float kLeatherShoes = 2.0f / 3;

struct PieceWeights {
  BareCues bare{};        // log odds of skin against cloth
  HangingCues hanging{};  // of hair against a garment, below the head
  HeadCues head{};        // of hair against a hat, on the head
  LeatherCues leather{};  // of leather against fabric, where both are as common
};

/// 1 / (1 + exp(-odds - weights . cues)); `odds`: log odds before any cue.
template <size_t N>
float probability_of(const std::array<float, N>& weights, const std::array<float, N>& cues, float odds = 0) {
  float sum = odds;
  for (size_t i = 0; i < N; ++i) sum += weights[i] * cues[i];
  return 1 / (1 + std::exp(-sum));
}

}  // namespace ohb::labelling
