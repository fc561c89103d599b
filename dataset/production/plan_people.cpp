#include "dataset/production/plan_people.h"

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <set>

#include "dataset/model/json_text.h"
#include "dataset/model/temporary.h"

namespace ohb::production {
namespace fs = std::filesystem;
namespace {

constexpr size_t kMostPeople = 9999, kLongestId = 64;

bool is_plain(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '-' ||
         c == '.';
}

std::string with_id(std::string pattern, const std::string& id) {
  // Onwards from what was put in: an id may hold "{id}" itself.
  for (size_t at = 0; (at = pattern.find("{id}", at)) != std::string::npos; at += id.size())
    pattern.replace(at, 4, id);
  return pattern;
}

/// What a person's attributes may be; `years` is people.json's word.
void add_attributes(const XmlDocument& xml, pugi::xml_node node, PlanPerson& person) {
  for (const char* name : {"sex", "group", "licence"})
    if (node.attribute(name)) person.attributes[name] = xml.text(node, name);
  if (node.attribute("age")) person.attributes["age"] = shortest(xml.number(node, "age", 0, 130));
}

void check_unit(const XmlDocument& xml, pugi::xml_node node, const std::string& unit) {
  if (!unit.empty() && unit != "mm" && unit != "cm" && unit != "m" && unit != "inch" && unit != "foot")
    throw xml.error(node, "unit=\"" + unit + "\" is not known", "write mm, cm, m, inch or foot");
}

PlanPerson read_person(const XmlDocument& xml, pugi::xml_node node) {
  xml.expect_attributes(
      node, {"id", "scan", "labels", "regions", "split", "unit", "sex", "age", "group", "licence"});
  xml.expect_children(node, {});
  PlanPerson person;
  person.id = xml.text(node, "id");
  person.split = xml.text(node, "split");
  expect_split(xml, node, person.split);
  person.scan = plan_path(xml, node, "scan", false);
  person.unit = xml.text_or(node, "unit", "");
  check_unit(xml, node, person.unit);
  person.is_automatic = xml.text_or(node, "labels", "") == "auto";
  const bool has_labels = !node.attribute("labels").empty(), has_regions = !node.attribute("regions").empty();
  if (has_labels == has_regions)
    throw xml.error(node,
                    "person '" + person.id + "' has " + (has_labels ? "both" : "neither") + " labels " +
                        (has_labels ? "and" : "nor") + " regions",
                    "give labels=\"FILE\", labels=\"auto\" or regions=\"FOLDER\"");
  if (has_regions) person.regions = plan_path(xml, node, "regions", true);
  if (has_labels && !person.is_automatic) person.labels = plan_path(xml, node, "labels", false);
  add_attributes(xml, node, person);
  return person;
}

/// How <people split="hash"> shares people out.
struct SplitRule {
  std::string fixed;  // a split's name; empty: by hash
  double train = 0, val = 0;
  std::optional<uint64_t> train_count;
};

SplitRule read_rule(const XmlDocument& xml, pugi::xml_node node) {
  SplitRule rule;
  const std::string split = xml.text(node, "split");
  if (split != "hash") {
    expect_split(xml, node, split);
    for (const char* name : {"train", "val", "train_count"})
      if (node.attribute(name))
        throw xml.error(node, std::string(name) + " is for split=\"hash\"",
                        "leave it out, or write split=\"hash\"");
    rule.fixed = split;
    return rule;
  }
  if (node.attribute("train_count")) {
    if (node.attribute("train") || node.attribute("val"))
      throw xml.error(node, "has both train_count and shares", "keep one");
    rule.train_count = xml.count(node, "train_count", kMostPeople);
    return rule;
  }
  rule.train = xml.number(node, "train", 0, 1);
  rule.val = node.attribute("val") ? xml.number(node, "val", 0, 1) : 0;
  if (rule.train + rule.val > 1) throw xml.error(node, "train and val together are above 1", "lower one");
  return rule;
}

void share_out(const SplitRule& rule, uint64_t seed, std::vector<PlanPerson>& people) {
  const auto hash = [&](const PlanPerson& p) {
    return hash_of_text("split/" + std::to_string(seed) + "/" + p.id);
  };
  std::sort(people.begin(), people.end(), [&](const PlanPerson& a, const PlanPerson& b) {
    return std::make_pair(hash(a), a.id) < std::make_pair(hash(b), b.id);
  });
  for (size_t i = 0; i < people.size(); ++i) {
    const double share = share_of_hash(hash(people[i]));
    if (!rule.fixed.empty())
      people[i].split = rule.fixed;
    else if (rule.train_count)
      people[i].split = i < *rule.train_count ? "train" : "test";
    else
      people[i].split = share < rule.train ? "train" : share < rule.train + rule.val ? "val" : "test";
  }
}

/// Of the folder's people.json, as `openhumanbrdf people` writes it: attributes by name. Empty without it.
std::map<std::string, std::map<std::string, std::string>> known_people(const fs::path& folder) {
  std::map<std::string, std::map<std::string, std::string>> known;
  const fs::path file = folder / "people.json";
  if (!fs::exists(file)) return known;
  try {
    for (const auto& row : read_json(file, kListingLimits).at("people")) {
      auto& attributes = known[row.at("name").get<std::string>()];
      attributes["sex"] = row.at("sex").get<std::string>();
      attributes["group"] = row.at("group").get<std::string>();
      attributes["age"] = shortest(row.at("years").get<double>());
    }
  } catch (const nlohmann::json::exception&) {
    throw InputError(file.string(), "", "is no list of people as `openhumanbrdf people` writes it",
                     "make it again, or remove it");
  }
  return known;
}

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory() && entry.path().filename().string()[0] != '.')
      names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// The place of one of a person's files by the element's pattern. Throws InputError if it is not there.
fs::path by_pattern(const XmlDocument& xml, pugi::xml_node node, const fs::path& folder,
                    const std::string& pattern, const std::string& id, bool is_folder) {
  const fs::path path = folder / with_id(pattern, id);
  if (is_folder ? !fs::is_directory(path) : !fs::is_regular_file(path))
    throw xml.error(node, "person '" + id + "' has no " + path.string(),
                    "add it, or remove the folder of that person");
  return path;
}

/// Where a folder has a person's files; {id} stands for the name.
struct FilePatterns {
  std::string scan, labels, regions;
};

FilePatterns read_patterns(const XmlDocument& xml, pugi::xml_node node) {
  FilePatterns patterns{xml.text_or(node, "scan", "{id}/{id}_scan.obj"),
                        xml.text_or(node, "labels", "{id}/{id}_scan.labels.txt"),
                        xml.text_or(node, "regions", "")};
  if (patterns.scan.find("{id}") == std::string::npos)
    throw xml.error(node, "scan=\"" + patterns.scan + "\" has no {id} in it",
                    "write {id} where the person's name stands");
  if (!patterns.regions.empty() && node.attribute("labels"))
    throw xml.error(node, "has both labels and regions", "keep one");
  return patterns;
}

std::vector<PlanPerson> read_folder(const XmlDocument& xml, pugi::xml_node node, uint64_t seed) {
  xml.expect_attributes(node, {"folder", "scan", "labels", "regions", "split", "train", "val", "train_count",
                               "unit", "licence", "sex", "age", "group"});
  xml.expect_children(node, {});
  const fs::path folder = plan_path(xml, node, "folder", true);
  const SplitRule rule = read_rule(xml, node);
  const FilePatterns patterns = read_patterns(xml, node);
  const std::string& scan = patterns.scan;
  const auto known = known_people(folder);
  std::vector<PlanPerson> people;
  for (const std::string& id : names_in(folder)) {
    if (!fs::is_regular_file(folder / with_id(scan, id))) continue;
    PlanPerson person;
    person.id = id;
    person.scan = folder / with_id(scan, id);
    person.is_automatic = patterns.labels == "auto" && patterns.regions.empty();
    person.unit = xml.text_or(node, "unit", "");
    check_unit(xml, node, person.unit);
    if (!patterns.regions.empty())
      person.regions = by_pattern(xml, node, folder, patterns.regions, id, true);
    else if (!person.is_automatic)
      person.labels = by_pattern(xml, node, folder, patterns.labels, id, false);
    if (const auto found = known.find(id); found != known.end()) person.attributes = found->second;
    add_attributes(xml, node, person);
    people.push_back(std::move(person));
  }
  for (const auto& [id, attributes] : known)
    if (std::none_of(people.begin(), people.end(), [&id = id](const PlanPerson& p) { return p.id == id; }))
      throw xml.error(node,
                      "person '" + id + "' of people.json has no " + (folder / with_id(scan, id)).string(),
                      "make the people again");
  if (people.empty())
    throw xml.error(node, folder.string() + " holds nobody: no folder in it has a " + scan,
                    "name the folder above those of the people, or say scan=\"...\"");
  share_out(rule, seed, people);
  return people;
}

}  // namespace

fs::path plan_path(const XmlDocument& xml, pugi::xml_node node, const char* attribute, bool is_folder) {
  const std::string text = xml.text(node, attribute);
  if (text.empty()) throw xml.error(node, std::string(attribute) + " is empty", "name a path");
  const fs::path path = (folder_of(xml.file()) / text).lexically_normal();
  std::error_code ignored;
  const bool is_there = is_folder ? fs::is_directory(path, ignored) : fs::is_regular_file(path, ignored);
  if (is_there) return path;
  const bool exists = fs::exists(path, ignored);
  throw xml.error(node,
                  std::string(attribute) + "=\"" + text + "\": " + path.string() +
                      (exists ? (is_folder ? " is no folder" : " is no file") : " does not exist"),
                  "correct the path, which is relative to the plan's folder");
}

void expect_plain_name(const XmlDocument& xml, pugi::xml_node node, const std::string& id) {
  if (id.empty() || id.size() > kLongestId || id[0] == '.' || !std::all_of(id.begin(), id.end(), is_plain))
    throw xml.error(node, "'" + id + "' cannot name a folder of the dataset",
                    "use 1 to 64 letters, digits, '_', '-' and '.', not '.' first");
}

void expect_split(const XmlDocument& xml, pugi::xml_node node, const std::string& split) {
  if (split != "train" && split != "val" && split != "test")
    throw xml.error(node, "split=\"" + split + "\" is not known", "write train, val or test");
}

std::vector<PlanPerson> read_people(const XmlDocument& xml, uint64_t seed) {
  std::vector<PlanPerson> people;
  std::set<std::string> seen;
  for (const pugi::xml_node& node : xml.root().children()) {
    const std::string name = node.name();
    if (name != "person" && name != "people") continue;
    for (PlanPerson& person :
         name == "people" ? read_folder(xml, node, seed) : std::vector<PlanPerson>{read_person(xml, node)}) {
      expect_plain_name(xml, node, person.id);
      std::string folded = person.id;  // some file systems know no case
      for (char& c : folded) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      if (!seen.insert(folded).second)
        throw xml.error(node, "a second person '" + person.id + "'", "give each an id of its own");
      people.push_back(std::move(person));
    }
  }
  if (people.empty())
    throw xml.error(xml.root(), "there are no people", "add <person .../> or <people folder=\"...\" .../>");
  if (people.size() > kMostPeople)
    throw xml.error(xml.root(), "there are more than 9999 people", "make several datasets");
  std::sort(people.begin(), people.end(),
            [](const PlanPerson& a, const PlanPerson& b) { return a.id < b.id; });
  return people;
}

}  // namespace ohb::production
