#include "dataset/model/progress.h"

#include <unistd.h>

#include <cstdio>

namespace ohb {
namespace {

constexpr double kQuietSeconds = 2, kRedrawSeconds = 0.2, kLineSeconds = 60;
constexpr int kBarWidth = 30;

double seconds_between(std::chrono::steady_clock::time_point a, std::chrono::steady_clock::time_point b) {
  return std::chrono::duration<double>(b - a).count();
}

}  // namespace

Progress::Progress(std::string label, size_t total, bool quiet)
    : label_(std::move(label)),
      total_(total),
      quiet_(quiet),
      terminal_(::isatty(STDERR_FILENO) != 0),
      start_(std::chrono::steady_clock::now()),
      last_drawn_(start_) {}

Progress::~Progress() {
  const double seconds = seconds_between(start_, std::chrono::steady_clock::now());
  if (quiet_ || seconds < kQuietSeconds) return;
  std::fprintf(stderr, "%s%s: %zu of %zu in %.1f s %s%s\n", terminal_ ? "\r" : "", label_.c_str(), done_,
               total_, seconds, note_.c_str(), terminal_ ? "                                        " : "");
}

void Progress::add(size_t steps) {
  const std::lock_guard<std::mutex> lock(mutex_);
  done_ += steps;
  const auto now = std::chrono::steady_clock::now();
  if (quiet_ || seconds_between(start_, now) < kQuietSeconds ||
      seconds_between(last_drawn_, now) < (terminal_ ? kRedrawSeconds : kLineSeconds))
    return;
  last_drawn_ = now;
  draw(seconds_between(start_, now));
}

void Progress::note(std::string words) {
  const std::lock_guard<std::mutex> lock(mutex_);
  note_ = std::move(words);
}

void Progress::draw(double seconds) {
  const double share = total_ ? static_cast<double>(done_) / static_cast<double>(total_) : 1;
  char bar[kBarWidth + 1];
  for (int i = 0; i < kBarWidth; ++i) bar[i] = i < share * kBarWidth ? '#' : '.';
  bar[kBarWidth] = 0;
  const double left = share > 0 ? seconds * (1 - share) / share : 0;
  std::fprintf(stderr, "%s%s [%s] %3.0f %%  %.0f s left %s%s", terminal_ ? "\r" : "", label_.c_str(), bar,
               100 * share, left, note_.c_str(), terminal_ ? "   " : "\n");
}

}  // namespace ohb
