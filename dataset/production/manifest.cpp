#include "dataset/production/manifest.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>
#include <set>

#include "dataset/model/atomic_file.h"
#include "dataset/model/conventions.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"
#include "dataset/model/xml_document.h"
#include "dataset/production/file_lock.h"
#include "dataset/production/units.h"

namespace ohb::production {
namespace fs = std::filesystem;
namespace {

void append_environments(pugi::xml_node parent, const Plan& plan, FileHashes& hashes) {
  pugi::xml_node node = parent.append_child("environments");
  for (const PlanEnvironment* environment : drawn_environments(plan)) {
    pugi::xml_node child = node.append_child("environment");
    child.append_attribute("name") = environment->name.c_str();
    child.append_attribute("sha256") = hashes.of(environment->file).c_str();
    if (!environment->split.empty()) child.append_attribute("split") = environment->split.c_str();
  }
}

void append_people(pugi::xml_node parent, const Plan& plan, const Layout& layout) {
  pugi::xml_node node = parent.append_child("people");
  for (const PlanPerson& person : plan.people) {
    const PersonState state = state_of(plan, person, layout);
    if (state.identity.empty()) continue;
    pugi::xml_node child = node.append_child("person");
    child.append_attribute("id") = person.id.c_str();
    child.append_attribute("split") = person.split.c_str();
    for (const auto& [name, value] : person.attributes) child.append_attribute(name.c_str()) = value.c_str();
    child.append_attribute("model") = ("humans/" + person.id + "/model").c_str();
    child.append_attribute("views") = ("humans/" + person.id + "/views").c_str();
    child.append_attribute("model_identity") = state.identity.c_str();
    child.append_attribute("sets") = static_cast<unsigned long long>(state.sets);
    child.append_attribute("planned_sets") = static_cast<unsigned long long>(state.set_count);
  }
}

std::string splits_text(const Plan& plan, const Layout& layout) {
  pugi::xml_document document;
  pugi::xml_node root = document.append_child("splits");
  root.append_attribute("schema") = kDatasetSchema;
  for (const char* name : {"train", "val", "test"}) {
    pugi::xml_node split = root.append_child("split");
    split.append_attribute("name") = name;
    for (const PlanPerson& person : plan.people)
      if (person.split == name && state_of(plan, person, layout).sets > 0)
        split.append_child("person").append_attribute("id") = person.id.c_str();
  }
  return xml_text(document);
}

}  // namespace

PersonState state_of(const Plan& plan, const PlanPerson& person, const Layout& layout) {
  PersonState state;
  state.set_count = static_cast<size_t>(plan.views_of(person).set_count());
  if (const auto marker = read_marker(layout, person.id, "bake"); marker && marker->facts.count("identity"))
    state.identity = marker->facts.at("identity");
  for (const std::string& unit : marked_units(layout, person.id)) state.sets += unit.rfind("set_", 0) == 0;
  return state;
}

std::vector<const PlanEnvironment*> drawn_environments(const Plan& plan) {
  std::set<const PlanEnvironment*> drawn;
  for (const PlanPerson& person : plan.people)
    for (const PlannedSet& set : sets_of(plan, person))
      drawn.insert(set.environments.begin(), set.environments.end());
  std::vector<const PlanEnvironment*> sorted(drawn.begin(), drawn.end());
  std::sort(sorted.begin(), sorted.end(),
            [](const PlanEnvironment* a, const PlanEnvironment* b) { return a->name < b->name; });
  return sorted;
}

void write_manifest(const Plan& plan, const Layout& layout, FileHashes& environments) {
  FileLock lock(layout.locks() / ".manifest", FileLock::Kind::kExclusive);
  lock.wait();
  pugi::xml_document document;
  pugi::xml_node root = document.append_child("dataset");
  root.append_attribute("schema") = kDatasetSchema;
  root.append_attribute("name") = plan.name.c_str();
  root.append_attribute("generator") = "openhumanbrdf " OHB_VERSION;
  root.append_attribute("plan_sha256") = plan.sha256.c_str();
  root.append_attribute("seed") = static_cast<unsigned long long>(plan.seed);
  append_conventions(root);
  append_materials(root.append_child("materials"), plan.materials);
  append_environments(root, plan, environments);
  append_people(root, plan, layout);
  const fs::path dataset = layout.root / "dataset.xml", splits = layout.root / "splits.xml";
  begin_unit(layout, "", kManifestUnit);
  write_file_atomically(dataset, xml_text(document));
  write_file_atomically(splits, splits_text(plan, layout));
  finish_unit(layout, "", kManifestUnit, {dataset, splits}, {plan.sha256, {}, {}});
}

DatasetPlan read_dataset_plan(const Layout& layout) {
  const fs::path file = layout.state() / "plan.json";
  if (!fs::is_regular_file(file))
    throw InputError(layout.root.string(), "", "is no dataset: there is no .ohb/plan.json in it",
                     "give the folder that `openhumanbrdf produce` wrote");
  try {
    const nlohmann::json json = read_json(file);
    if (const int schema = json.at("schema").get<int>(); schema > kDatasetSchema)
      throw InputError(layout.root.string(), "",
                       "was made by a newer version (" + json.at("version").get<std::string>() + ")",
                       "use that version or a later one");
    return {json.at("plan").get<std::string>(), json.at("sha256").get<std::string>()};
  } catch (const nlohmann::json::exception&) {
    throw InputError(file.string(), "", "is damaged", "remove it, and give `produce` the same command again");
  }
}

void write_dataset_plan(const Layout& layout, const Plan& plan) {
  const nlohmann::ordered_json json = {{"schema", kDatasetSchema},
                                       {"version", OHB_VERSION},
                                       {"plan", fs::absolute(plan.file).lexically_normal().string()},
                                       {"sha256", plan.sha256}};
  make_folders(layout.state());
  write_file_atomically(layout.state() / "plan.json", json_text(json, 1) + "\n");
}

}  // namespace ohb::production
