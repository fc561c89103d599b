// Clothes over body, clothes over clothes: inner layers are pressed in where they come through outer ones.
#pragma once

#include "dataset/people/person.h"

namespace ohb::people {

/// Drops the body's faces that a garment hides (its delete_verts) where the garment really lies over them,
/// and presses each inner layer below each outer one, in the pose. Long hair is lifted out of the shoulders,
/// and pressed below hats; what still comes through a hat goes.
void settle_layers(Person& person);

/// Where an inner layer still comes through.
struct Pokes {
  float depth_cm = 0;  // the deepest
  float area_cm2 = 0;  // of faces whose middle lies more than a millimetre outside
  std::string worst;   // "skin through shirt"
};
Pokes find_pokes(const Person& person);

}  // namespace ohb::people
