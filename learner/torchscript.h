// The trained networks as one TorchScript file, which PyTorch runs without this program.
#pragma once

#include <filesystem>

#include "learner/estimator.h"

namespace ohb::learner {

/// Shape and meaning of what the recorded network takes and gives.
struct ScriptReport {
  int64_t size_px = 0;     // sides of its pictures: those that it was trained at, where it errs least
  int64_t parameters = 0;  // how many numbers were learned
};

/// Writes what Estimator::estimate does as TorchScript: forward(picture, mask), picture (B, 3, size, size) as
/// input.png of `estimate` holds it (sRGB in [0, 1], times the mask), mask (B, 1, size, size), any B. It
/// returns a dictionary by the names of kMaps, in the units of MaterialMaps, and within the mask only does it
/// mean something. The file has what these are beside it, as JSON ("humanmaterial.json" of torch.jit.load's
/// _extra_files). The networks are recorded as they run, so that no second writing of them can differ.
/// Throws as check_output_file (the estimator's files are the inputs) and write_file_atomically.
ScriptReport write_torchscript(const Estimator& estimator, const std::filesystem::path& file);

}  // namespace ohb::learner
