// Where the person is in a photograph that comes without a mask.
#pragma once

#include <filesystem>
#include <optional>

#include "learner/photo.h"

namespace ohb::learner {

struct MattingOptions {
  /// An ONNX network that OpenCV reads: 1 x 3 x 256 x 256, RGB in [0, 1], to the probability of "person" in
  /// one plane of the same size. Without one GrabCut is tried, which takes what differs from the borders for
  /// the person, and says so.
  std::optional<std::filesystem::path> network;
  int person = 1;  // of those found, by area: 1 is the largest
};

/// What was found.
struct Matte {
  Image mask;      // 1, coverage, of the photo's size, soft at the edge
  int people = 0;  // connected regions that may be persons; two who touch are one
};

/// The network sees the whole photo, then once more the surroundings of the person that is asked for, so that
/// people who are small in the picture get an edge of their own scale. Within a thirtieth of the person's
/// longer side the edge goes where colours differ, by a graph cut (Rother, Kolmogorov and Blake 2004,
/// GrabCut), and follows the photo by a guided filter (He, Sun and Tang 2013). Throws InputError: a network
/// that cannot be read or has another form; nobody found, or fewer than `person`.
Matte find_person(const Photo& photo, const std::filesystem::path& photo_file, const MattingOptions& options);

/// Colours of the foreground alone where it covers a pixel in part: without it a bright background leaves a
/// bright rim. `photo.linear` is changed where 0 < mask < 1 or nearly so. Blur fusion, two passes (Forte
/// 2021, "Approximate Fast Foreground Colour Estimation", eq. 6 to 8).
void keep_foreground_colours(Photo& photo, const Image& mask);

}  // namespace ohb::learner
