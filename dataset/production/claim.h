// Whose a dataset's folder is, and which plan is at work in it.
#pragma once

#include <filesystem>
#include <memory>

#include "dataset/production/file_lock.h"
#include "dataset/production/layout.h"
#include "dataset/production/plan.h"

namespace ohb::production {

/// Makes the folder and marks it as a dataset. Throws InputError for one that holds other things. What
/// several of us that start at once leave there before the marker stands has names of ours.
void claim_dataset(const std::filesystem::path& output);

/// The lock that says which plan is at work: shared by those of the same plan, which is written down if need
/// be. Throws TryAgainError while `produce` is at work there with another plan.
std::unique_ptr<FileLock> lock_plan(const Plan& plan, const Layout& layout);

}  // namespace ohb::production
