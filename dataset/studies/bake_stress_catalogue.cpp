#include "dataset/studies/bake_stress.h"

namespace ohb::studies {
using nlohmann::json;
namespace {

BakeStressAcceptance acceptance_of(const json& from, BakeStressAcceptance base) {
  const std::pair<const char*, double*> numbers[] = {{"normal_deg", &base.normal_deg},
                                                     {"colour", &base.colour},
                                                     {"alpha", &base.alpha},
                                                     {"depth_cm", &base.depth_cm},
                                                     {"wrong", &base.wrong}};
  const std::pair<const char*, std::string*> words[] = {{"refused", &base.refused}, {"warned", &base.warned}};
  for (const auto& [key, value] : from.items()) {
    bool is_known = false;
    for (const auto& [name, number] : numbers)
      if (key == name) {
        *number = value.is_null() ? -1 : value.get<double>();
        is_known = true;
      }
    for (const auto& [name, text] : words)
      if (key == name) {
        *text = value.get<std::string>();
        is_known = true;
      }
    if (!is_known)
      throw InputError("", "accept", "'" + key + "' is no measure", "see dataset/studies/bake_stress.h");
  }
  return base;
}

BakeStressCase case_of(const json& from) {
  return read_hard_case<BakeStressPoint>(from, acceptance_of, [](const json&, BakeStressPoint&) {});
}

}  // namespace

std::vector<BakeStressCase> read_bake_stress_catalogue(const std::filesystem::path& file) {
  return read_json_catalogue<BakeStressCase>(file, "assets/stress/bake_catalogue.json", case_of);
}

}  // namespace ohb::studies
