// The two sides of a validation: the same passes in Cycles and here.
#pragma once

#include <atomic>
#include <filesystem>

#include "dataset/model/progress.h"
#include "renderer/validation/cycles_run.h"
#include "renderer/validation/cycles_scene.h"
#include "renderer/validation/statistics.h"

namespace ohb::validation {

/// All times are of one image (mean over a pass's seeds), loading apart.
struct SideCost {
  double load_s = 0, wall_s = 0, cpu_s = 0;
  double mean_squared_error = 0;  // of one image: mean of the variance over foreground pixels and channels
};

/// What one image of either side counts in a bar of progress.
constexpr size_t kStepsOfImage = 100;
size_t image_count(const std::vector<CyclesPass>& passes);

/// The passes' images in Cycles (4 channels). Progress goes to `shared`, or to a bar of its own. Throws as
/// run_cycles.
struct CyclesSide {
  std::vector<ImageStack> passes;
  SideCost cost;                     // of the first pass
  std::vector<SideCost> pass_costs;  // of each
  std::vector<CyclesSetting> settings;
};
CyclesSide render_cycles_side(const CyclesScene& scene, const Blender& blender, int threads,
                              const std::filesystem::path& scratch, Progress* shared = nullptr);

/// The passes' images here (3 channels). `seed` is hashed with the number of pass and image.
struct OurSide {
  std::vector<ImageStack> passes;
  SideCost cost;                     // of the first pass
  std::vector<SideCost> pass_costs;  // of each
  uint64_t nonfinite = 0;
};
class OurRenderer {
 public:
  explicit OurRenderer(const CyclesScene& scene);
  /// Mask, classes and the other maps of the view.
  Sample maps() const;
  OurSide render(const std::vector<CyclesPass>& passes, uint64_t seed, Progress* shared = nullptr) const;

 private:
  ImageStack render_pass(const CyclesPass& pass, uint64_t seed, std::atomic<uint64_t>& nonfinite,
                         Progress& progress) const;
  renderer::RenderSettings settings() const;

  const CyclesScene& scene_;
  double load_s_ = 0;
  std::shared_ptr<const renderer::Scene> built_;
  std::shared_ptr<const renderer::LightSet> lights_;
};

}  // namespace ohb::validation
