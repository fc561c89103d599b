// Jobs side by side, of which each uses all threads inside.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace ohb::bake {

using Jobs = std::vector<std::function<void()>>;

/// So many at a time. If some throw, those that run are finished, no others are begun, and what the first of
/// them in the list threw is thrown. TBB's own ways would cancel the loops inside the others, which would go
/// on with half of their results.
void run_jobs(const Jobs& jobs, size_t at_once);
inline void run_side_by_side(const Jobs& jobs) {
  run_jobs(jobs, jobs.size());
}

}  // namespace ohb::bake
