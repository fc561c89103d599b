// What a run is: the header of its checkpoints, and whether a folder may take it.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "learner/data.h"
#include "learner/train.h"

namespace ohb::learner {

/// What a resumed run must have in common with the run that it goes on with: options, people, the content of
/// the views that it trains on (identity_of_views) and of the priors that guide it.
nlohmann::json run_header(const TrainOptions& options, const Dataset& dataset, const Split& split,
                          int64_t steps);

/// Throws InputError, naming `file` and what differs, unless `before` (of a checkpoint) and `now` are of one
/// run. Views and priors count where the checkpoint notes them; older versions did not.
void check_same_run(const nlohmann::json& before, const nlohmann::json& now,
                    const std::filesystem::path& file);

/// Throws InputError if a run would overwrite weights or a log that no run of ours is known to have written:
/// another program's, or those of a run whose checkpoints somebody removed.
void check_is_run(const std::filesystem::path& run, bool has_checkpoint);

}  // namespace ohb::learner
