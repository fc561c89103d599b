// From figures to words.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "renderer/validation/validate.h"

namespace ohb::validation {
namespace {

constexpr double kAimedHalfWidth = 0.4;  // of the threshold, as validate() aims
constexpr double kLeastTimesMore = 2;    // less would be left to chance

std::string percent(double value) {
  return fmt::format("{:+.3f} %", 100 * value);
}

void worsen(Verdict& verdict, Outcome outcome, const std::string& reason) {
  verdict.outcome = std::max(verdict.outcome, outcome);
  verdict.reasons.push_back(reason);
}

/// "skin", "skin and hair", "skin, hair and fabric".
std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  return text;
}

std::string duration(double seconds) {
  if (seconds < 90) return fmt::format("{:.0f} seconds", std::max(1.0, seconds));
  if (seconds < 90 * 60) return fmt::format("{:.0f} minutes", seconds / 60);
  return fmt::format("{:.0f} hours", seconds / 3600);
}

bool is_outside(const Interval& ratio, const ValidationThresholds& limits) {
  return ratio.low > 1 + limits.ratio || ratio.high < 1 - limits.ratio;
}

bool is_inside(const Interval& ratio, const ValidationThresholds& limits) {
  return ratio.low >= 1 - limits.ratio && ratio.high <= 1 + limits.ratio;
}

/// How many times the paths that region's interval needs, from the noise that it had.
double times_more(const RegionResult& result, const Validation& v) {
  const ValidationThresholds& limits = v.settings.thresholds;
  const Interval& ratio = result.ratio.total;
  const double half_width = 0.5 * (ratio.high - ratio.low), target = kAimedHalfWidth * limits.ratio;
  const double done = static_cast<double>(result.work.seeds) * result.work.cycles_spp /
                      (static_cast<double>(v.settings.seeds) * v.settings.spp);
  // Up to `focus` times the paths come by themselves.
  return done * half_width * half_width / (target * target) / std::max(1.0, v.settings.focus);
}

/// "`--spp 256`, about 4 minutes": what would decide it. Paths in powers of two, then seeds.
std::string advice(double times, const Validation& v) {
  const ValidationSettings& s = v.settings;
  int spp = s.spp, seeds = std::max(s.seeds, s.thresholds.seeds);
  const double wanted = times * s.spp * s.seeds;
  while (spp < kMaxCyclesSpp && static_cast<double>(spp) * seeds < wanted)
    spp = std::min(2 * spp, kMaxCyclesSpp);
  if (static_cast<double>(spp) * seeds < wanted)
    seeds = static_cast<int>(std::min(1024.0, std::ceil(wanted / spp)));
  std::string options = spp > s.spp ? fmt::format("--spp {}", spp) : "";
  if (seeds > s.seeds) options += fmt::format("{}--seeds {}", options.empty() ? "" : " ", seeds);
  const double share = static_cast<double>(spp) * seeds / (static_cast<double>(s.spp) * s.seeds);
  return fmt::format("`{}`, about {}", options, duration(share * v.seconds));
}

/// One rejected bin alone is no difference yet: where both sides agree, one picture in a hundred has it, and
/// two one in some twenty thousand.
Outcome judged_bins(const Validation& v) {
  if (v.inside_bins.accepted_share >= v.settings.thresholds.accepted_share) return Outcome::kPass;
  return v.inside_bins.bins - v.inside_bins.accepted > 1 ? Outcome::kDifference : Outcome::kUndecided;
}

std::string sentence_of_difference(const Validation& v) {
  const ValidationThresholds& limits = v.settings.thresholds;
  std::vector<std::string> found;
  for (const RegionResult& region : v.regions)
    if (is_judged(region.ratio, limits) && is_outside(region.ratio.total, limits))
      found.push_back(fmt::format("{} is {:.2f} % {}", region.ratio.name,
                                  100 * std::abs(region.ratio.total.value - 1),
                                  region.ratio.total.value > 1 ? "brighter" : "darker"));
  if (judged_bins(v) == Outcome::kDifference)
    found.push_back(
        fmt::format("{:.1f} % of the places look different", 100 * (1 - v.inside_bins.accepted_share)));
  if (v.nonfinite > 0) found.push_back("some of ours is not a number");
  if (found.empty()) found.push_back("Blender did not keep its settings");
  return "differs from Cycles: " + listed(found);
}

std::string sentence_of(const Validation& v, Outcome outcome) {
  const ValidationThresholds& limits = v.settings.thresholds;
  const std::string within = fmt::format("within {:.1f} %", 100 * limits.ratio);
  if (outcome == Outcome::kPass) return "looks the same, " + within + " of Cycles in every region";
  if (outcome == Outcome::kDifference) return sentence_of_difference(v);
  std::vector<std::string> noisy;
  double times = 1;
  for (const RegionResult& region : v.regions)
    if (is_judged(region.ratio, limits) && !is_inside(region.ratio.total, limits)) {
      noisy.push_back(region.ratio.name);
      times = std::max({times, times_more(region, v), kLeastTimesMore});
    }
  const bool few_seeds = v.settings.seeds < limits.seeds;
  if (noisy.empty() && !few_seeds)
    return "looks the same but for one place, which may be chance: try another `--seed`";
  const std::string unsure = noisy.empty()
                                 ? fmt::format("{} images a side are too few to be sure", v.settings.seeds)
                                 : "too noisy to be sure of " + listed(noisy) + " " + within;
  return "looks the same; " + unsure + ": " + advice(times, v);
}

void judge_region(const RegionRatio& region, const ValidationThresholds& limits, Verdict& verdict) {
  const Interval& ratio = region.total;
  if (!is_judged(region, limits)) return;
  if (is_inside(ratio, limits)) return;
  const std::string words =
      fmt::format("{}: ours / Cycles - 1 is {}, 95 % interval {} to {}", region.name,
                  percent(ratio.value - 1), percent(ratio.low - 1), percent(ratio.high - 1));
  if (is_outside(ratio, limits))
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
  if (const Outcome bins = judged_bins(v); bins != Outcome::kPass)
    worsen(verdict, bins,
           fmt::format(
               "{:.2f} % of the 3 x 3 px bins are accepted, not {:.1f} %{}",
               100 * v.inside_bins.accepted_share, 100 * limits.accepted_share,
               bins == Outcome::kDifference
                   ? "."
                   : ": one is not, which chance does to one picture in a hundred; use another --seed."));
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
  verdict.sentence = sentence_of(v, verdict.outcome);
  return verdict;
}

}  // namespace ohb::validation
