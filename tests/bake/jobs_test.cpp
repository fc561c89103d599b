#include "bake/jobs.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <stdexcept>
#include <thread>

namespace ohb {
using namespace bake;
namespace {

TEST(Jobs, OneThatThrowsLeavesTheLoopsOfOthersWhole) {
  const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);
  constexpr int kWork = 1000;
  for (int round = 0; round < 5; ++round) {
    std::atomic<bool> is_begun{false}, is_thrown{false};
    std::atomic<int> done{0}, others{0};
    const Jobs jobs = {[&] {
                         is_begun = true;
                         while (!is_thrown) std::this_thread::yield();
                         // The exception is on its way out of the other job, on a busy machine for some
                         // while.
                         std::this_thread::sleep_for(std::chrono::milliseconds(100));
                         tbb::parallel_for(0, kWork, [&](int) { ++done; });
                       },
                       [&] {
                         while (!is_begun) std::this_thread::yield();
                         is_thrown = true;
                         throw std::runtime_error("full");
                       },
                       [&] { ++others; }, [&] { ++others; }, [&] { ++others; }};
    EXPECT_THROW(run_jobs(jobs, 2), std::runtime_error);
    EXPECT_EQ(done, kWork);
    EXPECT_LE(others, 1) << "no more are begun";
  }
}

TEST(Jobs, TheFirstInTheListIsThrownThoughItCameLater) {
  const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);
  std::atomic<bool> is_begun{false}, is_thrown{false};
  const Jobs jobs = {[&] {
                       is_begun = true;
                       while (!is_thrown) std::this_thread::yield();
                       throw std::runtime_error("a");
                     },
                     [&] {
                       while (!is_begun) std::this_thread::yield();
                       is_thrown = true;
                       throw std::runtime_error("b");
                     }};
  try {
    run_side_by_side(jobs);
    ADD_FAILURE();
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "a");
  }
}

TEST(Jobs, AllAreRun) {
  std::atomic<int> sum{0};
  Jobs jobs;
  for (int i = 0; i < 100; ++i) jobs.push_back([&sum, i] { sum += i; });
  run_jobs(jobs, 3);
  EXPECT_EQ(sum, 4950);
  run_jobs({}, 1);
}

}  // namespace
}  // namespace ohb
