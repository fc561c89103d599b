// What labelling knows of each pair of classes; a new class adds a row and a column to each table.
#pragma once

#include <array>

#include "dataset/model/regions.h"

namespace ohb::labelling {

using ClassPairs = std::array<std::array<float, kClassCount>, kClassCount>;

/// Width in cm of the border of each pair of classes, from where one is alone to where the other is: hair
/// thins out over 8 mm of skin and lies 3 mm over clothes; a hem is 0.8 mm.
constexpr ClassPairs kBorderWidth_cm = {
    {{0, 0.8f, 0.08f, 0.08f}, {0.8f, 0, 0.3f, 0.3f}, {0.08f, 0.3f, 0, 0.08f}, {0.08f, 0.3f, 0.08f, 0}}};

/// What a border of faces costs. A metric: hair borders skin softly, leather and hair hardly ever meet.
constexpr ClassPairs kClassDistance = {
    {{0, 0.8f, 1, 1}, {0.8f, 0, 1, 1.5f}, {1, 1, 0, 0.7f}, {1, 1.5f, 0.7f, 0}}};

/// A table that forgot a new class has zeros where two classes meet.
constexpr bool is_whole(const ClassPairs& table) {
  for (int a = 0; a < kClassCount; ++a)
    for (int b = 0; b < kClassCount; ++b)
      if ((table[a][b] > 0) != (a != b) || table[a][b] != table[b][a]) return false;
  return true;
}
static_assert(is_whole(kBorderWidth_cm) && is_whole(kClassDistance), "each pair of classes needs its values");

/// 1 for each pair: all classes are equally unlike.
constexpr ClassPairs alike_distances() {
  ClassPairs table{};
  for (int a = 0; a < kClassCount; ++a)
    for (int b = 0; b < kClassCount; ++b) table[a][b] = a == b ? 0.0f : 1.0f;
  return table;
}

}  // namespace ohb::labelling
