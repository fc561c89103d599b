// Work on rows and tiles by all threads: TBB; under ThreadSanitizer plain threads, since Debian's TBB is not
// instrumented and what it orders would look like races (the tasks, which are ours, are the same).
#pragma once

#include <tbb/blocked_range2d.h>
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

/// body(range) for tiles of tile_px or less that cover rows [y0, y1) and columns [x0, x1).
template <typename Body>
void parallel_tiles(int y0, int y1, int x0, int x1, int tile_px, const Body& body) {
  const int across = (x1 - x0 + tile_px - 1) / tile_px, down = (y1 - y0 + tile_px - 1) / tile_px;
  parallel_for_each(0, across * down, [&](int tile) {
    const int y = y0 + tile / across * tile_px, x = x0 + tile % across * tile_px;
    body(tbb::blocked_range2d<int>(y, std::min(y + tile_px, y1), x, std::min(x + tile_px, x1)));
  });
}
#else
template <typename Body>
void parallel_for_each(int first, int last, const Body& body) {
  tbb::parallel_for(first, last, body);
}

template <typename Body>
void parallel_tiles(int y0, int y1, int x0, int x1, int tile_px, const Body& body) {
  tbb::parallel_for(tbb::blocked_range2d<int>(y0, y1, tile_px, x0, x1, tile_px), body,
                    tbb::simple_partitioner());
}
#endif

}  // namespace ohb
