// A light blue sky with one bright texel, in memory.
#pragma once

#include "tests/support/test_models.h"

namespace ohb {

inline Environment sky_with_sun(float sun) {
  Environment environment;
  environment.name = "sunny";
  environment.radiance = constant_radiance({0.3f, 0.4f, 0.5f}, 32);
  for (int c = 0; c < 3; ++c) environment.radiance.pixel(44, 9)[c] = sun;
  return environment;
}

}  // namespace ohb
