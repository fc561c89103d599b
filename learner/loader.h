// Examples ahead of time, in an order that is a function of the seed alone.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include "learner/data.h"

namespace ohb::learner {

/// Where the example at a position of the endless sequence comes from. Each epoch is a permutation of the
/// views, a function of seed and epoch; the light is a function of seed and position.
struct Draw {
  size_t view;
  uint64_t light_key;
};
Draw draw_at(uint64_t seed, uint64_t position, size_t view_count);

/// Hands out the examples of positions first, first + 1, ...: equal for any number of threads, and a loader
/// that starts later goes on exactly where an earlier one stopped.
class Loader {
 public:
  struct Settings {
    int size_px = 128;
    uint64_t seed = 1, first_position = 0;
    int threads = 1, ahead = 4;  // examples held ready at most
    // Positions in blocks: `block` of them, then on to `stride` after the block's first.
    uint64_t block = 1, stride = 1;
    Variations keys = {};  // of the run: each position has keys of its own
    /// Done to each example once it is read, with its position, by the threads that read.
    std::function<void(Example&, uint64_t)> vary = {};
  };
  /// Throws InputError if there is no view.
  Loader(std::vector<std::filesystem::path> views, Settings settings);
  ~Loader();
  Loader(const Loader&) = delete;
  Loader& operator=(const Loader&) = delete;

  /// The next example. Throws what reading or varying it threw (InputError naming the file).
  Example next();
  /// Seconds that next() has waited for files so far.
  double waited_s() const { return waited_s_; }

 private:
  struct Result {
    Example example;
    std::exception_ptr error;
  };
  void work();
  /// Where in the order of examples the n-th one that is handed out stands.
  uint64_t position_of(uint64_t n) const {
    return settings_.first_position + n / settings_.block * settings_.stride + n % settings_.block;
  }

  std::vector<std::filesystem::path> views_;
  Settings settings_;
  uint64_t next_to_read_ = 0, next_to_give_ = 0;
  double waited_s_ = 0;
  bool stopping_ = false;
  std::map<uint64_t, Result> ready_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::thread> workers_;
};

}  // namespace ohb::learner
