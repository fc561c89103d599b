// As many paths as an error asks for, and no bias from asking.
#pragma once

#include "renderer/render.h"

namespace ohb::renderer {

struct ErrorGoal {
  double relative_error = 0.01;
  int max_spp = 16384;  // paths a pixel at most (mean over the seen pixels, pilots included)
};

/// Estimated relative error of one light's image over one region: the root of
///   sum of E[(image - truth)^2] / sum of truth^2
/// over the region's pixels and channels. Regions are the whole subject ("subject") and, by what the middle
/// of each pixel sees, the classes with at least 100 pixels.
struct RegionError {
  std::string light, region;
  double relative_error = 0;
  size_t pixels = 0;
};

struct ErrorReport {
  bool met = false;                 // else max_spp was reached first
  double spp = 0;                   // mean over the seen pixels, pilots included
  std::vector<RegionError> errors;  // of the result: each light's subject first, then its classes

  /// The largest of them; null if nothing is seen.
  const RegionError* worst() const;
  const RegionError* worst_of(const std::string& light) const;
};

/// Called between rounds with the largest error so far.
using RoundDone = std::function<void(double relative_error)>;

/// Who hears of the progress of a call; each may be left out.
struct RenderWatch {
  RenderStatistics* statistics = nullptr;
  PixelsDone done = nullptr;
  RoundDone round_done = nullptr;
};

/// render_lights until the estimated error of every region of every light is at most the goal
/// (settings.spp is not used). How, so that it stays unbiased: pilot images, not used otherwise, share the
/// paths out among pixels (settings.adaptive) and regions and set a fixed schedule of rounds. Then four
/// independent images grow by that schedule. The first two stop at the first round at which the other two
/// differ so little that the goal is met, and the other way round; so where an image stops does not depend
/// on its own values. The result is the mean of all four with fixed weights. (Weights or stops from an
/// image's own values favour what happens to be dark: Kirk and Arvo, "Unbiased Sampling Techniques for Image
/// Synthesis", 1991.) The reported errors are from all four. Bit-identical for any thread count.
std::vector<SampleLight> render_to_error(const LitView& view, const RenderSettings& settings,
                                         const ErrorGoal& goal, ErrorReport& report,
                                         const RenderWatch& watch = {});

}  // namespace ohb::renderer
