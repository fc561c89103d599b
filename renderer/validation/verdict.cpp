// From figures to words.
#include <fmt/format.h>

#include <algorithm>

#include "renderer/validation/validate.h"

namespace ohb {
namespace {

std::string percent(double value) {
  return fmt::format("{:+.3f} %", 100 * value);
}

void worsen(Verdict& verdict, Outcome outcome, const std::string& reason) {
  verdict.outcome = std::max(verdict.outcome, outcome);
  verdict.reasons.push_back(reason);
}

void judge_region(const RegionRatio& region, const ValidationThresholds& limits, Verdict& verdict) {
  const Interval& ratio = region.total;
  if (!is_judged(region, limits)) return;
  if (ratio.low >= 1 - limits.ratio && ratio.high <= 1 + limits.ratio) return;
  const std::string words =
      fmt::format("{}: ours / Cycles - 1 is {}, 95 % interval {} to {}", region.name,
                  percent(ratio.value - 1), percent(ratio.low - 1), percent(ratio.high - 1));
  if (ratio.low > 1 + limits.ratio || ratio.high < 1 - limits.ratio)
    worsen(verdict, Outcome::kDifference, words + ": a difference.");
  else
    worsen(verdict, Outcome::kUndecided,
           words +
               fmt::format(": not narrow enough to tell within {:.1f} %; use more --spp, --seeds or --focus.",
                           100 * limits.ratio));
}

}  // namespace

bool is_judged(const RegionRatio& region, const ValidationThresholds& thresholds) {
  return region.weight_px >= thresholds.least_region_px;
}

Verdict judge(const Validation& v) {
  const ValidationThresholds& limits = v.settings.thresholds;
  Verdict verdict;
  for (const CyclesSetting& setting : v.blender_settings)
    if (!setting.same)
      worsen(verdict, Outcome::kDifference,
             fmt::format("Blender did not keep a setting: {} was set to {} and is {}.", setting.name,
                         setting.wanted, setting.found));
  if (v.nonfinite > 0)
    worsen(verdict, Outcome::kDifference,
           fmt::format("{} contributions of ours were NaN or infinite.", v.nonfinite));
  for (const RegionResult& region : v.regions) judge_region(region.ratio, limits, verdict);
  if (v.inside_bins.accepted_share < limits.accepted_share)
    worsen(verdict, Outcome::kDifference,
           fmt::format("{:.2f} % of the 3 x 3 px bins are accepted, not {:.1f} %.",
                       100 * v.inside_bins.accepted_share, 100 * limits.accepted_share));
  if (v.settings.seeds < limits.seeds)
    worsen(
        verdict, Outcome::kUndecided,
        fmt::format("{} seeds a side are too few to judge; {} are needed.", v.settings.seeds, limits.seeds));
  if (verdict.outcome == Outcome::kPass)
    verdict.reasons.push_back(
        fmt::format("Every region's mean is within {:.1f} % of Cycles', 95 % interval included, and {:.2f} % "
                    "of the bins are "
                    "accepted.",
                    100 * limits.ratio, 100 * v.inside_bins.accepted_share));
  return verdict;
}

}  // namespace ohb
