// A progress bar with the time left, on stderr, for anything that takes over two seconds.
#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>

namespace ohb {

/// Redrawn on a terminal; elsewhere a line a minute and one at the end. Thread-safe.
class Progress {
 public:
  /// `quiet` draws nothing.
  Progress(std::string label, size_t total, bool quiet = false);
  ~Progress();
  void add(size_t steps = 1);
  /// Words that follow the bar from now on.
  void note(std::string words);

 private:
  void draw(double seconds);

  std::string label_, note_;
  size_t total_, done_ = 0;
  bool quiet_, terminal_;
  std::chrono::steady_clock::time_point start_, last_drawn_;
  std::mutex mutex_;
};

}  // namespace ohb
