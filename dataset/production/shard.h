// Which part of a plan's people a machine makes.
#pragma once

#include <string>
#include <vector>

#include "dataset/production/plan.h"

namespace ohb::production {

struct Shard {
  int index = 1, count = 1;  // index from 1
};

/// "2/16". Throws InputError unless 1 <= i <= n <= 9999.
Shard parse_shard(const std::string& text);

/// The people of a shard, those with most sets first. Every person is in exactly one of a plan's n shards,
/// and these differ by at most one person.
std::vector<const PlanPerson*> people_of_shard(const Plan& plan, const Shard& shard);

}  // namespace ohb::production
