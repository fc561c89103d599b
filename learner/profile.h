// What a training step's time goes to: the operators that libtorch ran, by kind.
#pragma once

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace ohb::learner {

/// One kind of work.
struct ProfileLine {
  std::string kind;
  double seconds = 0;
  int64_t calls = 0;
};

/// Times all operators of the process between its construction and lines(): each without those that it
/// calls. Observing costs about a microsecond an operator. One at a time; throws std::logic_error otherwise.
class StepProfile {
 public:
  StepProfile();
  ~StepProfile();
  StepProfile(const StepProfile&) = delete;
  StepProfile& operator=(const StepProfile&) = delete;

  /// Kinds by time, most first, then "everything else" (waiting for data, host code) so that the sum is the
  /// time on the wall since the construction.
  std::vector<ProfileLine> lines() const;

 private:
  uint64_t handle_;
  std::chrono::steady_clock::time_point start_;
};

/// Kind of the operator of this name: "convolutions", "matrix products", "norms", ...
std::string kind_of_operator(const std::string& name);

/// A table, one kind a line, with seconds, share and calls a step.
std::string table_of(const std::vector<ProfileLine>& lines, int64_t steps);
nlohmann::json json_of(const std::vector<ProfileLine>& lines);

}  // namespace ohb::learner
