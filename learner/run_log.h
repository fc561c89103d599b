// What a training run says: JSON lines in the run's folder, and one line of progress on stderr.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace ohb::learner {

/// RUN/log.jsonl. Opening it drops the lines of steps after `last_step`, which an interrupted run may have
/// written beyond its last checkpoint, and a torn last line.
class RunLog {
 public:
  RunLog(const std::filesystem::path& file, int64_t last_step);
  /// Written at once, so that a kill loses nothing. Throws TryAgainError if the disk is full.
  void add(const nlohmann::json& event);

 private:
  std::filesystem::path file_;
  std::ofstream stream_;
};

/// "[####......] step 40/100, 8.2 steps/s, loss 0.1234, waiting for data 1 %, 12 s left": redrawn on a
/// terminal, a line a minute elsewhere.
class TrainProgress {
 public:
  TrainProgress(int64_t first_step, int64_t steps, bool quiet);
  ~TrainProgress();
  void show(int64_t step, double loss, double data_wait_s);
  double seconds() const;

 private:
  using Clock = std::chrono::steady_clock;
  int64_t first_step_, steps_;
  bool quiet_, terminal_, drawn_ = false;
  Clock::time_point start_, last_;
};

}  // namespace ohb::learner
