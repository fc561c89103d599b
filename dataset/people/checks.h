// What can go wrong with a person, measured: cloth that lets skin through, limbs inside the body, floating
// hair.
#pragma once

#include <string>

#include "dataset/people/layers.h"

namespace ohb::people {

struct PersonFaults {
  Pokes pokes;
  float limb_depth_cm = 0;  // how deep a limb lies in another part of the body
  int limb_vertices = 0;    // that lie deeper than a centimetre
  float hair_gap_cm = 0;    // largest distance of a lock (cards that touch) from what it could hang on

  /// In words, or "" if the person may pass.
  std::string verdict() const;
};

/// Of a settled person.
PersonFaults find_faults(const Assets& assets, const Person& person);

}  // namespace ohb::people
