// Who shares which candidates of the lights: all paths of a picture that belong to one block of samples.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "renderer/lights.h"

namespace ohb::renderer {

/// Consecutive samples that share a pool: 1, 1, 2, 4, ... 64, 64, ... of them, whatever budget they belong
/// to.
struct PoolBlock {
  uint32_t first, end;
  /// The block that a sample belongs to.
  static PoolBlock around(uint32_t sample);
  static constexpr uint32_t kLargest = 64;
};

/// A tile of a picture: its first pixel.
struct TilePlace {
  int x_px, y_px;
};

/// The pools of one seed's picture. Filling one costs as much as tracing many paths, so tiles share them, and
/// they can be large: what a pool misses of its light is an error that all its paths have in common. In large
/// pictures regions of kRegion_px have one of four sets, so that this error differs over the picture. Past
/// kSharedSamples each tile has smaller pools of its own: the error then goes on falling with the number of
/// paths. So it has under very many environments, whose pools would fill the memory: what is shared takes 300
/// MB at most.
class LightPools {
 public:
  /// Refers to `lights`. `with_cells`: the candidates know their DirectionCells.
  LightPools(const LightSet& lights, double turn_rad, uint64_t seed, bool with_cells);

  /// One pool an environment, for pixels of a class (0 where classes share): the picture's, which lives as
  /// long as this does and is filled by the thread that asks first, or `own`, filled for that tile. What they
  /// hold is a function of the arguments and of the seed.
  const std::vector<LightPool>& at(const PoolBlock& block, int pixel_class, const TilePlace& tile,
                                   std::vector<LightPool>& own);

 private:
  static constexpr uint32_t kSharedSamples = 1024;
  static constexpr int kRegion_px = 256;
  static constexpr size_t kMostWithRegions = 8, kMostShared = 32;  // environments
  struct Shared {
    std::once_flag filled;
    std::vector<LightPool> pools;
  };
  void fill(int candidates_log2, uint64_t key, std::vector<LightPool>& pools) const;

  const LightSet& lights_;
  double turn_rad_;
  uint64_t seed_;
  bool with_cells_;
  std::mutex mutex_;
  std::map<std::pair<uint32_t, uint64_t>, Shared> shared_;  // by first sample, class and set
};

}  // namespace ohb::renderer
