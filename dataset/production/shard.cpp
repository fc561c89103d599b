#include "dataset/production/shard.h"

#include <algorithm>
#include <charconv>

#include "dataset/model/error.h"

namespace ohb::production {
namespace {

constexpr int kMostShards = 9999;

}  // namespace

Shard parse_shard(const std::string& text) {
  Shard shard;
  const char* const end = text.data() + text.size();
  const auto [slash, error] = std::from_chars(text.data(), end, shard.index);
  bool good = error == std::errc() && slash != end && *slash == '/';
  if (good) {
    const auto [last, failure] = std::from_chars(slash + 1, end, shard.count);
    good = failure == std::errc() && last == end;
  }
  if (!good || shard.count < 1 || shard.count > kMostShards || shard.index < 1 || shard.index > shard.count)
    throw InputError("", "--shard " + text, "is no shard",
                     "write i/n with 1 <= i <= n <= 9999, for example 2/16");
  return shard;
}

std::vector<const PlanPerson*> people_of_shard(const Plan& plan, const Shard& shard) {
  std::vector<const PlanPerson*> all, ours;
  for (const PlanPerson& person : plan.people) all.push_back(&person);
  std::stable_sort(all.begin(), all.end(), [&](const PlanPerson* a, const PlanPerson* b) {
    return plan.views_of(*a).set_count() > plan.views_of(*b).set_count();
  });
  for (size_t i = static_cast<size_t>(shard.index - 1); i < all.size(); i += static_cast<size_t>(shard.count))
    ours.push_back(all[i]);
  return ours;
}

}  // namespace ohb::production
