// environments synthesise: computed lights, into a library.
#pragma once

#include <cstdint>
#include <filesystem>

#include "dataset/environments/import.h"

namespace ohb::environments {

struct SynthesisJob {
  uint64_t count = 310;
  uint64_t seed = 1;
  int width_px = 1024;
  std::filesystem::path library;
  bool quiet = false;
};

constexpr uint64_t kMostSynthesised = 9999;

/// Maps "s<seed>_<index>_<category>" of index 0 to count - 1; each depends on seed, index and width alone.
/// Those that are there are left as they are. Licence CC0-1.0. Throws InputError (the library), TryAgainError
/// (disk full, SIGINT or SIGTERM: finished maps stay).
LibraryChange synthesise_environments(const SynthesisJob& job);

}  // namespace ohb::environments
