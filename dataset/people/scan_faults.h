// What makes real scans harder: noise of the surface, holes, light that was baked into the picture.
#pragma once

#include "dataset/people/person.h"

namespace ohb::people {

struct ScanFaults {
  float noise_cm = 0;    // standard deviation along the normal, at the vertices
  int holes = 0;         // patches of 1 to 4 cm radius that were not captured
  bool shading = false;  // soft light from above and in front, with its shadows, in the picture
};

/// Moves the vertices along their normals: half of the variance alone, half smooth over 3 cm.
void add_noise(Person& person, float deviation_cm);

/// Drops the faces around points of the surface. Needs faces that can be seen alone.
void cut_holes(Person& person, int count);

/// Irradiance of each part's vertices under a soft sky that is brighter above and in front, relative to an
/// open surface that faces it.
std::vector<std::vector<float>> soft_shading(const Person& person);

}  // namespace ohb::people
