#include "dataset/production/claim.h"

#include "dataset/model/error.h"
#include "dataset/production/manifest.h"

namespace ohb::production {
namespace fs = std::filesystem;

std::unique_ptr<FileLock> lock_plan(const Plan& plan, const Layout& layout) {
  auto lock = std::make_unique<FileLock>(layout.locks() / ".plan", FileLock::Kind::kExclusive);
  const bool is_alone = lock->held();
  if (!is_alone) {
    lock->share();
    lock->wait();  // for one that is just writing down its plan
  }
  const bool is_known = fs::exists(layout.state() / "plan.json");
  if (!is_alone && (!is_known || read_dataset_plan(layout).sha256 != plan.sha256))
    throw TryAgainError(layout.root.string(), "another `produce` is at work there with another plan",
                        "wait for it, or choose another -o");
  if (is_alone) {
    if (is_known) read_dataset_plan(layout);  // throws if a newer version wrote it
    write_dataset_plan(layout, plan);         // the same plan may lie elsewhere now
  }
  lock->share();
  lock->wait();
  return lock;
}

}  // namespace ohb::production
