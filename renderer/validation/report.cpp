#include "renderer/validation/report.h"

#include <nlohmann/json.hpp>

#include "dataset/model/atomic_file.h"
#include "dataset/model/json_text.h"
#include "renderer/validation/pictures.h"
#include "renderer/validation/report_pictures.h"

namespace ohb::validation {
namespace fs = std::filesystem;
using json = nlohmann::ordered_json;
namespace {

const char* word_of(Outcome outcome) {
  return outcome == Outcome::kPass ? "pass" : outcome == Outcome::kUndecided ? "undecided" : "difference";
}

json to_json(const Interval& interval) {
  return {{"value", interval.value}, {"low", interval.low}, {"high", interval.high}};
}

json to_json(const RegionResult& result, const ValidationThresholds& limits) {
  const RegionRatio& region = result.ratio;
  return {{"name", region.name},
          {"pixels", region.weight_px},
          {"judged", is_judged(region, limits)},
          {"seeds", result.work.seeds},
          {"spp_ours", result.work.our_spp},
          {"spp_cycles", result.work.cycles_spp},
          {"mean_ours", region.mean_a},
          {"mean_cycles", region.mean_b},
          {"ratio", to_json(region.total)},
          {"ratio_red", to_json(region.channel[0])},
          {"ratio_green", to_json(region.channel[1])},
          {"ratio_blue", to_json(region.channel[2])}};
}

json to_json(const BinTest& bins) {
  return {{"bins", bins.bins},
          {"accepted", bins.accepted},
          {"accepted_share", bins.accepted_share},
          {"alpha_of_one_test", bins.single_alpha},
          {"share_with_p_below_5_percent", bins.below_5_percent},
          {"median_detectable_relative_difference", bins.median_detectable}};
}

json to_json(const SideCost& cost) {
  return {{"load_s", cost.load_s},
          {"wall_s", cost.wall_s},
          {"cpu_s", cost.cpu_s},
          {"mean_squared_error", cost.mean_squared_error}};
}

json settings_json(const ValidationSettings& s) {
  return {{"view", s.view},   {"view_count", s.view_count}, {"size_px", s.size_px},
          {"spp", s.spp},     {"seeds", s.seeds},           {"bounces", s.max_bounces},
          {"focus", s.focus}, {"threads", s.threads},       {"seed", s.seed}};
}

void write_moments(const fs::path& file, const Moments& moments) {
  const std::vector<std::string> rgb = {"R", "G", "B"};
  write_exr(file,
            {{"mean", rgb, ExrPart::Type::kFloat, moments.mean},
             {"variance_of_one_seed", rgb, ExrPart::Type::kFloat, moments.variance}},
            {});
}

}  // namespace

std::string validation_json(const Validation& v) {
  const ValidationThresholds& limits = v.settings.thresholds;
  json regions = json::array(), blender = json::array();
  for (const RegionResult& region : v.regions) regions.push_back(to_json(region, limits));
  for (const CyclesSetting& setting : v.blender_settings)
    blender.push_back({{"name", setting.name},
                       {"wanted", parse_json<json>(setting.wanted, setting.name)},
                       {"found", parse_json<json>(setting.found, setting.name)},
                       {"same", setting.same}});
  const SpeedRatio speed = speed_at_equal_error(v);
  const json result = {
      {"verdict", word_of(v.verdict.outcome)},
      {"sentence", v.verdict.sentence},
      {"reasons", v.verdict.reasons},
      {"model", v.model_name},
      {"environment", v.environment_name},
      {"blender", v.blender_version},
      {"shading", v.settings.shading == renderer::ShadingModel::kV1 ? "Principled v1" : "Principled v2"},
      {"subsurface", !v.has_subsurface       ? "none"
                     : v.settings.subsurface ? "random walk"
                                             : "set to 0 on both sides"},
      {"settings", settings_json(v.settings)},
      {"thresholds",
       {{"ratio", limits.ratio}, {"accepted_share", limits.accepted_share}, {"seeds", limits.seeds}}},
      {"regions", regions},
      {"outline", to_json(v.band, limits)},
      {"bins", to_json(v.inside_bins)},
      {"outline_bins", to_json(v.band_bins)},
      {"coverage", {{"ours", v.coverage_ours}, {"cycles", v.coverage_cycles}}},
      {"cost", {{"ours", to_json(v.our_cost)}, {"cycles", to_json(v.cycles_cost)}}},
      {"speed_at_equal_error", {{"wall", speed.wall}, {"cpu", speed.cpu}}},
      {"seconds", v.seconds},
      {"nonfinite", v.nonfinite},
      {"blender_settings", blender}};
  return json_text(result, 1) + "\n";
}

void write_validation(const fs::path& folder, const Validation& v) {
  const ReportScales scales = report_scales(v);
  const std::vector<uint8_t>& shown = v.pixels.foreground;
  write_png(folder / "ours.png", display_picture(v.ours.mean, v.coverage, scales.exposure));
  write_png(folder / "cycles.png", display_picture(v.cycles.mean, v.coverage, scales.exposure));
  write_png(
      folder / "difference.png",
      diverging_picture(relative_difference(v.ours.mean, v.cycles.mean, shown), shown, scales.difference));
  write_png(folder / "z.png", diverging_picture(all_z(v), shown, scales.z));
  write_moments(folder / "ours.exr", v.ours);
  write_moments(folder / "cycles.exr", v.cycles);
  write_file_atomically(folder / "validate.json", validation_json(v));
  write_file_atomically(folder / "index.html", validation_html(v));
}

}  // namespace ohb::validation
