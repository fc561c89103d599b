#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "dataset/commands/delight.h"

namespace ohb::commands {

std::vector<std::string> warnings_of(const DelightReport& report) {
  std::vector<std::string> warnings;
  for (const DelightRegion& region : report.regions)
    if (!region.is_delit)
      warnings.push_back(fmt::format(
          "delight: {} was left as it is: there is nothing to delight, its colours do not follow the light "
          "that its surroundings leave it (slope {:.2f}; 1 is baked shading, {:g} the least)",
          region.name, region.slope, kLeastSlope));
  return warnings;
}

nlohmann::ordered_json to_json(const DelightReport& report) {
  nlohmann::ordered_json json = {{"rays_a_position", kDelightRays},
                                 {"least_irradiance", kLeastIrradiance},
                                 {"least_slope", kLeastSlope},
                                 {"regions", nlohmann::ordered_json::array()}};
  for (const DelightRegion& region : report.regions)
    json["regions"].push_back({{"name", region.name},
                               {"texels", region.texels},
                               {"slope", region.slope},
                               {"delit", region.is_delit},
                               {"mean_irradiance", region.mean_irradiance},
                               {"least_irradiance", region.least_irradiance},
                               {"mean_luminance", region.mean_luminance},
                               {"least_gain", region.least_gain},
                               {"most_gain", region.most_gain},
                               {"deep_share", region.deep_share}});
  json["warnings"] = warnings_of(report);
  return json;
}

std::string to_text(const DelightReport& report) {
  std::string text;
  for (const DelightRegion& region : report.regions)
    text += fmt::format(
        "  delight {:<8} {}: irradiance {:.2f} (least {:.2f}), slope {:.2f}; texels times {:.2f} to {:.2f}, "
        "{:.1f} % too deep to divide by all of it\n",
        region.name, region.is_delit ? "divided" : "left alone", region.mean_irradiance,
        region.least_irradiance, region.slope, region.least_gain, region.most_gain, 100 * region.deep_share);
  for (const std::string& warning : warnings_of(report)) text += "warning: " + warning + "\n";
  return text;
}

}  // namespace ohb::commands
