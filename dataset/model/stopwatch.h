// Wall and processor time of a stretch of work.
#pragma once

#include <chrono>
#include <ctime>

namespace ohb {

/// Starts when it is made.
struct Stopwatch {
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  std::clock_t processor_start = std::clock();  // of all threads of this process
  double wall_s() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  double cpu_s() const { return static_cast<double>(std::clock() - processor_start) / CLOCKS_PER_SEC; }
};

}  // namespace ohb
