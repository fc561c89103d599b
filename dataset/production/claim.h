// Which plan is at work in a dataset's folder.
#pragma once

#include <memory>

#include "dataset/production/file_lock.h"
#include "dataset/production/layout.h"
#include "dataset/production/plan.h"

namespace ohb::production {

/// The lock that says which plan is at work: shared by those of the same plan, which is written down if need
/// be. Throws TryAgainError while `produce` is at work there with another plan.
std::unique_ptr<FileLock> lock_plan(const Plan& plan, const Layout& layout);

}  // namespace ohb::production
