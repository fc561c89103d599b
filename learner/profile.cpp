#include "learner/profile.h"

#include <ATen/record_function.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <mutex>
#include <stdexcept>

namespace ohb::learner {
namespace {

using Clock = std::chrono::steady_clock;

struct Running : at::ObserverContext {
  Clock::time_point start;
};

/// Sums of the one profile that runs. Operators may run on several threads.
std::mutex sums_mutex;
std::map<std::string, ProfileLine> sums;
bool is_running = false;
/// Seconds that the operators called by each running operator of this thread took, innermost last.
thread_local std::vector<double> inner_s;

std::unique_ptr<at::ObserverContext> begin(const at::RecordFunction&) {
  inner_s.push_back(0);
  auto running = std::make_unique<Running>();
  running->start = Clock::now();
  return running;
}

void end(const at::RecordFunction& function, at::ObserverContext* context) {
  const double whole =
      std::chrono::duration<double>(Clock::now() - static_cast<Running*>(context)->start).count();
  if (inner_s.empty()) return;
  const double own = whole - inner_s.back();
  inner_s.pop_back();
  if (!inner_s.empty()) inner_s.back() += whole;
  const std::string kind = kind_of_operator(function.name());
  const std::lock_guard<std::mutex> lock(sums_mutex);
  ProfileLine& line = sums[kind];
  line.kind = kind;
  line.seconds += own;
  ++line.calls;
}

}  // namespace

std::string kind_of_operator(const std::string& name) {
  static constexpr std::array<std::pair<const char*, const char*>, 16> kKinds = {{
      {"rendering loss", "rendering loss"},
      {"optimiser", "optimiser"},
      {"upsample", "up-sampling"},  // before "linear", which "bilinear" has
      {"pool", "up-sampling"},
      {"conv", "convolutions"},
      {"mm", "matrix products"},
      {"linear", "matrix products"},
      {"group_norm", "norms"},
      {"layer_norm", "norms"},
      {"norm_silu", "norms"},
      {"silu", "activations"},
      {"gelu", "activations"},
      {"softmax", "activations"},
      {"cat", "copies and sums"},
      {"cop", "copies and sums"},
      {"add", "copies and sums"},
  }};
  for (const auto& [part, kind] : kKinds)
    if (name.find(part) != std::string::npos) return kind;
  return "other operators";
}

StepProfile::StepProfile() : handle_(0), start_(Clock::now()) {
  {
    const std::lock_guard<std::mutex> lock(sums_mutex);
    if (is_running) throw std::logic_error("a second profile at the same time");
    is_running = true;
    sums.clear();
  }
  handle_ = at::addGlobalCallback(at::RecordFunctionCallback(begin, end));
}

StepProfile::~StepProfile() {
  at::removeCallback(handle_);
  const std::lock_guard<std::mutex> lock(sums_mutex);
  is_running = false;
}

std::vector<ProfileLine> StepProfile::lines() const {
  double rest = std::chrono::duration<double>(Clock::now() - start_).count();
  std::vector<ProfileLine> lines;
  {
    const std::lock_guard<std::mutex> lock(sums_mutex);
    for (const auto& [kind, line] : sums) lines.push_back(line);
  }
  for (const ProfileLine& line : lines) rest -= line.seconds;
  std::sort(lines.begin(), lines.end(),
            [](const ProfileLine& a, const ProfileLine& b) { return a.seconds > b.seconds; });
  lines.push_back({"everything else", std::max(0.0, rest), 0});
  return lines;
}

std::string table_of(const std::vector<ProfileLine>& lines, int64_t steps) {
  double all = 0;
  for (const ProfileLine& line : lines) all += line.seconds;
  std::string table = "| a step's time | ms | % | calls |\n|---|---:|---:|---:|\n";
  const double count = static_cast<double>(std::max<int64_t>(1, steps));
  for (const ProfileLine& line : lines) {
    char text[160];
    std::snprintf(text, sizeof text, "| %s | %.1f | %.1f | %.0f |\n", line.kind.c_str(),
                  1e3 * line.seconds / count, all > 0 ? 100 * line.seconds / all : 0,
                  static_cast<double>(line.calls) / count);
    table += text;
  }
  return table;
}

nlohmann::json json_of(const std::vector<ProfileLine>& lines) {
  nlohmann::json json = nlohmann::json::object();
  for (const ProfileLine& line : lines) json[line.kind] = {{"seconds", line.seconds}, {"calls", line.calls}};
  return json;
}

}  // namespace ohb::learner
