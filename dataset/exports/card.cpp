#include <fmt/format.h>

#include <map>

#include "dataset/exports/forms.h"
#include "dataset/exports/realism.h"
#include "dataset/model/map_table.h"
#include "dataset/model/regions.h"

namespace ohb::exports {
namespace {

using Counts = std::map<std::string, size_t>;

/// A table with bars of letters, which any viewer shows.
std::string table_of(const std::string& what, const std::string& of, const Counts& counts) {
  size_t most = 1, sum = 0;
  for (const auto& [name, count] : counts) most = std::max(most, count), sum += count;
  std::string text = fmt::format("| {} | {} | share | |\n|---|---:|---:|---|\n", what, of);
  for (const auto& [name, count] : counts)
    text += fmt::format("| {} | {} | {:.1f} % | {} |\n", name.empty() ? "(none)" : name, count,
                        100.0 * static_cast<double>(count) / static_cast<double>(sum),
                        std::string((20 * count + most - 1) / most, '#'));
  return text + "\n";
}

}  // namespace

std::string card_text(const SampleIndex& index, const std::vector<std::vector<std::string>>& lights,
                      bool has_realism) {
  Counts people_of_split, sets_of_split, sets_of_light;
  std::map<std::string, Counts> people_of_value;
  for (const IndexedPerson& person : index.people) {
    ++people_of_split[person.split];
    for (const auto& [name, value] : person.attributes) ++people_of_value[name][value];
  }
  for (size_t i = 0; i < index.samples.size(); ++i) {
    ++sets_of_split[index.people[index.samples[i].person].split];
    for (const std::string& light : lights[i]) ++sets_of_light[light];
  }
  std::string text = fmt::format("# {}\n\n{} people, {} sets under {} lights.\n\n", index.name,
                                 index.people.size(), index.samples.size(), sets_of_light.size());
  text += "Each set: a mask, maps (normal, albedo, displacement";
  for (const MaterialMap& map : kMaterialMaps) text += std::string(", ") + map.name;
  text += "), shares of the classes (" + class_list(", ", ", ") +
          ") and lit pictures. Made by openhumanbrdf " OHB_VERSION ".\n\n";
  text += "![one picture a person](contact_sheet.png)\n\n";
  if (has_realism)
    text +=
        "## What each step adds\n\n![steps of realism](realism.png)\n\nFrom left to right, each as the whole "
        "person "
        "and the head, under the bundled studio: " +
        fmt::format("{}", fmt::join(realism_steps(), "; ")) +
        ". The last two are alike where scans brought no normal maps.\n\n";
  text += "## Splits\n\n" + table_of("split", "people", people_of_split) +
          table_of("split", "sets", sets_of_split);
  text += "## Balance\n\n";
  for (const auto& [name, counts] : people_of_value) text += table_of(name, "people", counts);
  if (people_of_value.empty()) text += "No attributes of the people are known.\n\n";
  text += "## Lights\n\n" + table_of("light", "sets", sets_of_light);
  text += "## Licences\n\n";
  const auto licences = people_of_value.find("licence");
  text += licences == people_of_value.end()
              ? "The dataset states no licences of its people: ask who made it before you pass it on.\n"
              : "As stated for the people: see the table of `licence` above. Lights have those of their "
                "library.\n";
  return text;
}

}  // namespace ohb::exports
