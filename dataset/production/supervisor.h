// Makes a dataset: one worker process a person, so many at once, watched, retried, and given up with the
// reason where nothing helps; the others go on.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "dataset/production/plan.h"
#include "dataset/production/shard.h"

namespace ohb::production {

struct ProduceJob {
  Plan plan;
  std::filesystem::path output;
  Shard shard;
  int workers = 1;
  int threads = 1;       // of all workers together
  double stall_s = 900;  // a worker without a sign of life for so long is killed
  bool quiet = false;
};

struct GivenUp {
  std::string id, reason;
};

struct ProduceReport {
  size_t people = 0, sets = 0;  // of this shard
  size_t there = 0, made = 0;   // sets
  size_t retries = 0;
  double seconds = 0;
  /// What the workers' seconds went to: label, bake, loading (models), environments, maps, lights, writing.
  /// Of people who were finished.
  std::map<std::string, double> worker_s;
  std::vector<GivenUp> given_up;
  std::vector<std::string> busy;  // people whom another process is making
};

/// Makes what is missing of the shard's people, then writes dataset.xml and splits.xml. One supervisor a
/// shard: a second one with the same --shard is refused; those of other shards share the folder, as each
/// person is locked by its worker. Those who were given up are tried again by the next run. Throws InputError
/// (output of another kind, an environment that vanished), TryAgainError (another supervisor of this shard,
/// or of another plan; the plan changed meanwhile; disk full; stopped: all workers are ended, what is
/// finished is kept).
ProduceReport produce(const ProduceJob& job);

std::string to_text(const ProduceReport& report, const std::filesystem::path& output);
nlohmann::ordered_json to_json(const ProduceReport& report);

}  // namespace ohb::production
