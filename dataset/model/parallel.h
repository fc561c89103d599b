// Work by all threads: TBB; under ThreadSanitizer plain threads, since Debian's TBB is not
// instrumented and what it orders would look like races (the tasks, which are ours, are the same).
#pragma once

#include <tbb/parallel_for.h>

#ifdef __SANITIZE_THREAD__
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>
#endif

namespace ohb {

#ifdef __SANITIZE_THREAD__
/// body(i) for first <= i < last, on four threads in any order; throws what a body threw first.
template <typename Body>
void parallel_for_each(int first, int last, const Body& body) {
  std::atomic<int> next{first};
  std::mutex mutex;
  std::exception_ptr thrown;
  const auto work = [&] {
    try {
      for (int i = next++; i < last; i = next++) body(i);
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex);
      if (!thrown) thrown = std::current_exception();
      next = last;
    }
  };
  std::vector<std::thread> threads;
  for (int k = 0; k < 4; ++k) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  if (thrown) std::rethrow_exception(thrown);
}

#else
template <typename Body>
void parallel_for_each(int first, int last, const Body& body) {
  tbb::parallel_for(first, last, body);
}
#endif

}  // namespace ohb
