// Rounds of paths over the pixels of one view: what every way to spend a budget is made of.
#pragma once

#include <vector>

#include "renderer/budget.h"
#include "renderer/path_tracer.h"

namespace ohb::renderer {

/// One call's scene, lights, view and pixels. Refers to the scene, lights and settings that it is made of.
struct Picture {
  Picture(const LitView& view, const RenderSettings& settings);

  PathContext context;
  ViewCamera view;
  const RenderSettings& settings;
  PixelBox box;
  std::vector<uint8_t> seen;  // 1 a pixel that may see something, as of footprint()

  /// `spp` paths for every seen pixel.
  std::vector<uint32_t> even_budget(int spp) const;
};

/// Paths of each pixel: the numbers [first, first + count) of the seed's. Rounds of one seed that follow each
/// other are one longer round (the samples stay stratified over all of them).
struct PathRange {
  uint64_t seed = 1;
  const std::vector<uint32_t>& count;
  const std::vector<uint32_t>* first = nullptr;  // null: 0
  bool by_class = false;                         // pixels of different pixel_class() share no random numbers
};

/// Mean radiance of each pixel's paths; a pixel of count 0, or outside the box, stays black. If `work` is set
/// (as many values as pixels), what the paths of each took is added there: their number and their rays.
std::vector<SampleLight> render_round(const Picture& picture, const PathRange& paths,
                                      RenderStatistics& statistics, const PixelsDone& done,
                                      std::vector<float>* work = nullptr);

/// Independent images of `spp` paths a seen pixel, from seeds that nothing else uses: what they tell may
/// decide how later paths are spent without biasing those.
Pilots render_pilots(const Picture& picture, int images, int spp, RenderStatistics& statistics,
                     const PixelsDone& done);

}  // namespace ohb::renderer
