// Pictures of one person that go from harmless to impossible.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "learner/data.h"

namespace ohb::learner {

/// One view of a person, lit in two ways by our path tracer.
struct StressSubject {
  Example example;         // truth and mask
  torch::Tensor sky, sun;  // (1, 3, N, N), linear radiance of the foreground, of equal means
  uint64_t key = 0;        // of the noise
};

/// What the networks get, what they are judged by, and at which size they run.
struct StressPicture {
  torch::Tensor input;  // network_input
  torch::Tensor mask;   // the true one
  MaterialMaps truth;
  int network_px = 0;       // input is averaged down or interpolated to it, the estimate back
  bool same_pixels = true;  // they show what the harmless picture's show
};

struct StressKind {
  std::string name, parameter;  // parameter: heading of its axis
  std::vector<double> levels;   // in order
  double harmless;              // one of them, where the picture is that of all other kinds
  std::function<StressPicture(const StressSubject&, double level)> picture;
};

/// The harmless picture: sky and sun of equal mean, exposed as training does it (the 95th percentile of the
/// foreground's largest channel at 0.8 linear), in front of a mid-grey wall, cut out by the true mask.
///
/// contrast  sun over sky, stops
/// exposure  stops over that exposure, clipped at 1
/// colour    stops of red over green and of green over blue in the light
/// noise     deviation of Gaussian noise on sRGB values
/// jpeg      quality: the DCT and the tables of ITU-T T.81 (annex K), scaled as libjpeg does, 4:4:4
/// mask      pixels that it is too large (with wall) or too small
/// crop      share of the person's height that is in the picture, from the top, enlarged to fill it
/// size      side of what the networks see over that of the samples
std::vector<StressKind> stress_kinds(int size_px);

/// sRGB picture (1, 3, H, W), H and W multiples of 8, after JPEG of that quality (1 to 100).
torch::Tensor as_jpeg(const torch::Tensor& srgb, int quality);

}  // namespace ohb::learner
