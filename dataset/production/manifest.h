// dataset.xml and splits.xml: what a dataset holds, written anew from what is there.
#pragma once

#include "dataset/production/file_hashes.h"
#include "dataset/production/layout.h"
#include "dataset/production/plan.h"

namespace ohb::production {

constexpr int kDatasetSchema = 1;
constexpr const char* kManifestUnit = "manifest";  // of dataset.xml and splits.xml; nobody's: id ""

/// How far one person is.
struct PersonState {
  std::string identity;            // of the model; empty: not baked yet
  size_t sets = 0, set_count = 0;  // done (by their markers), planned
  bool is_done() const { return !identity.empty() && sets == set_count; }
};
/// By the markers; hashes are not compared.
PersonState state_of(const Plan& plan, const PlanPerson& person, const Layout& layout);

/// Writes both files. Equal states give equal bytes. Processes that write at the same time wait for each
/// other, so that the last one to finish has seen what all others made.
void write_manifest(const Plan& plan, const Layout& layout, FileHashes& environments);

/// The environments that any set of the plan draws, sorted by name.
std::vector<const PlanEnvironment*> drawn_environments(const Plan& plan);

/// Which plan a dataset is made by, and by which version.
struct DatasetPlan {
  std::filesystem::path plan;  // absolute
  std::string sha256;
};
/// Throws InputError: not a dataset, or one that a newer version made.
DatasetPlan read_dataset_plan(const Layout& layout);
void write_dataset_plan(const Layout& layout, const Plan& plan);

}  // namespace ohb::production
