// A production as a job array of Slurm: task i of N runs `produce --shard i/N`. Tasks may be killed, run into
// their time limit and be queued again at any moment: what is finished is kept, and the bytes are the same.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "dataset/production/plan.h"

namespace ohb::production {

struct SubmitJob {
  Plan plan;
  std::filesystem::path output;
  int tasks = 0;                    // 0: one a person, or as many as the cluster takes
  int at_once = 0;                  // tasks that run at the same time; 0: as the cluster likes
  int threads = 0;                  // processor cores of a task; 0: as the cluster gives
  std::string time, partition;      // as sbatch's; empty: the cluster's
  std::vector<std::string> sbatch;  // further options of sbatch: "account=lab", "exclusive"
};

struct SubmitReport {
  std::string job;  // Slurm's number of the array; empty if it was not queued
  int tasks = 0;
  size_t people = 0;
  std::string script;
};

/// What `submit` would queue; writes nothing, and needs no Slurm. Throws InputError: options that sbatch's
/// script cannot hold, more tasks than the cluster takes in one array.
SubmitReport prepare(const SubmitJob& job);

/// Queues the array, writes its script and its record to the dataset's folder, and the plan, so that `status`
/// knows it. Throws as prepare; InputError, in sbatch's words: no sbatch here, sbatch refuses; TryAgainError:
/// no answer from the cluster, an earlier array of this dataset is not over, a `produce` of another plan.
SubmitReport submit(const SubmitJob& job);

std::string to_text(const SubmitReport& report, const std::filesystem::path& output);
nlohmann::ordered_json to_json(const SubmitReport& report);

}  // namespace ohb::production
