#include "learner/run_log.h"

#include <unistd.h>

#include <cstdio>
#include <sstream>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"

namespace ohb::learner {
namespace {

constexpr double kRedraw_s = 0.2, kLine_s = 60;
constexpr int kBarWidth = 20;

/// Torn lines of a run that was killed, and what others wrote there, are dropped.
bool is_kept(const std::string& line, int64_t last_step) {
  try {
    const nlohmann::json event = parse_json(line, "log.jsonl");
    return event.is_object() && event.value("step", int64_t{0}) <= last_step;
  } catch (const InputError&) {
    return false;
  } catch (const nlohmann::json::exception&) {  // a step that is no number
    return false;
  }
}

}  // namespace

RunLog::RunLog(const std::filesystem::path& file, int64_t last_step) : file_(file) {
  std::string kept;
  if (std::filesystem::exists(file)) {
    std::istringstream old(read_file(file));
    for (std::string line; std::getline(old, line);) {
      if (is_kept(line, last_step)) kept += line + "\n";
    }
  }
  write_file_atomically(file, kept);
  stream_.open(file, std::ios::app);
  if (!stream_) throw InputError(file.string(), "", "cannot be written", "check the folder's permissions");
}

void RunLog::add(const nlohmann::json& event) {
  stream_ << json_text(event) << "\n" << std::flush;
  if (!stream_)
    throw TryAgainError(file_.string(), "cannot be written", "free some space and go on with --resume");
}

TrainProgress::TrainProgress(int64_t first_step, int64_t steps, bool quiet)
    : first_step_(first_step),
      steps_(steps),
      quiet_(quiet),
      terminal_(::isatty(STDERR_FILENO) != 0),
      start_(Clock::now()),
      last_(start_) {}

TrainProgress::~TrainProgress() {
  if (drawn_ && terminal_) std::fprintf(stderr, "\n");
}

double TrainProgress::seconds() const {
  return std::chrono::duration<double>(Clock::now() - start_).count();
}

void TrainProgress::show(int64_t step, double loss, double data_wait_s) {
  const auto now = Clock::now();
  const double since = std::chrono::duration<double>(now - last_).count();
  if (quiet_ || since < (terminal_ ? kRedraw_s : kLine_s)) return;
  last_ = now;
  drawn_ = true;
  const double elapsed = seconds(), done = static_cast<double>(step - first_step_);
  const double left = static_cast<double>(steps_ - step) * elapsed / done;
  char bar[kBarWidth + 1] = {};
  for (int i = 0; i < kBarWidth; ++i)
    bar[i] = static_cast<double>(i) * static_cast<double>(steps_) < static_cast<double>(step) * kBarWidth
                 ? '#'
                 : '.';
  std::fprintf(stderr,
               "%s[%s] step %lld/%lld, %.2f steps/s, loss %.4f, waiting for data %.0f %%, %.0f s left%s",
               terminal_ ? "\r" : "", bar, static_cast<long long>(step), static_cast<long long>(steps_),
               done / elapsed, loss, 100 * data_wait_s / elapsed, left, terminal_ ? "   " : "\n");
}

}  // namespace ohb::learner
