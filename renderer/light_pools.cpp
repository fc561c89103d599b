#include "renderer/light_pools.h"

#include <algorithm>

namespace ohb::renderer {
namespace {

constexpr uint64_t kPoolSeeds = 0x706f6f6cull;
// Binary logarithms of candidates a sample, measured: a picture's, and a tile's own. What a path's own
// question to one of many environments takes is less.
constexpr int kSharedLog2 = 7, kSharedLog2OfMany = 6;
constexpr int kLeastSharedLog2 = 11;  // of all candidates
constexpr int kOwnLog2 = 5, kOwnLog2OfMany = 4;

}  // namespace

PoolBlock PoolBlock::around(uint32_t sample) {
  if (sample == 0) return {0, 1};
  if (sample >= kLargest) return {sample & ~(kLargest - 1), (sample | (kLargest - 1)) + 1};
  const int bits = 31 - __builtin_clz(sample);
  return {1u << bits, 2u << bits};
}

LightPools::LightPools(const LightSet& lights, double turn_rad, uint64_t seed, bool with_cells)
    : lights_(lights), turn_rad_(turn_rad), seed_(seed), with_cells_(with_cells) {}

void LightPools::fill(int candidates_log2, uint64_t key, std::vector<LightPool>& pools) const {
  const int columns_log2 = (candidates_log2 + 1) / 2;
  pools.resize(lights_.environments.size());
  for (size_t l = 0; l < pools.size(); ++l)
    pools[l].fill(lights_.environments[l], turn_rad_, columns_log2, candidates_log2 - columns_log2, key,
                  with_cells_);
}

const std::vector<LightPool>& LightPools::at(const PoolBlock& block, int pixel_class, const TilePlace& tile,
                                             std::vector<LightPool>& own) {
  const size_t environments = lights_.environments.size();
  const bool is_one = environments <= 1;
  const int samples_log2 = 31 - __builtin_clz(block.end - block.first);
  const auto sharing = static_cast<uint64_t>(pixel_class) << 32;
  if (block.first >= kSharedSamples || environments > kMostShared) {
    const uint64_t number = static_cast<uint64_t>(tile.y_px) << 32 | static_cast<uint64_t>(tile.x_px);
    fill(samples_log2 + (is_one ? kOwnLog2 : kOwnLog2OfMany),
         mix_bits(mix_bits(seed_ ^ (kPoolSeeds + sharing)) + number) + block.first, own);
    return own;
  }
  const int region = tile.y_px / kRegion_px % 2 * 2 + tile.x_px / kRegion_px % 2;
  const uint64_t set = environments > kMostWithRegions ? 0 : static_cast<uint64_t>(region);
  Shared* shared;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    shared = &shared_[{block.first, sharing + set}];
  }
  std::call_once(shared->filled, [&] {
    fill(std::max(kLeastSharedLog2, samples_log2 + (is_one ? kSharedLog2 : kSharedLog2OfMany)),
         mix_bits(seed_ ^ (kPoolSeeds + sharing + set)) + block.first, shared->pools);
  });
  return shared->pools;
}

}  // namespace ohb::renderer
