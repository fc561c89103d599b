#include "bake/jobs.h"

#include <tbb/parallel_pipeline.h>

#include <atomic>
#include <exception>

namespace ohb::bake {

void run_jobs(const Jobs& jobs, size_t at_once) {
  std::vector<std::exception_ptr> thrown(jobs.size());
  std::atomic<bool> has_thrown{false};
  size_t next = 0;
  tbb::parallel_pipeline(
      at_once,
      tbb::make_filter<void, size_t>(tbb::filter_mode::serial_in_order, [&](tbb::flow_control& flow) {
        if (next == jobs.size() || has_thrown) flow.stop();
        return next++;
      }) & tbb::make_filter<size_t, void>(tbb::filter_mode::parallel, [&](size_t job) {
        try {
          jobs[job]();
        } catch (...) {
          thrown[job] = std::current_exception();
          has_thrown = true;
        }
      }));
  for (const std::exception_ptr& exception : thrown)
    if (exception) std::rethrow_exception(exception);
}

}  // namespace ohb::bake
