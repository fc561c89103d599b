#include "dataset/exports/sample_index.h"

#include <algorithm>
#include <set>

#include "dataset/model/error.h"
#include "dataset/model/sample.h"
#include "dataset/model/sample_listing.h"
#include "dataset/model/xml_document.h"

namespace ohb::exports {
namespace fs = std::filesystem;
namespace {

constexpr uint64_t kSchema = 1, kMostSets = 1000000;

std::string value_of(const ExrAttributes& attributes, const std::string& name) {
  for (const auto& [key, value] : attributes)
    if (key == name) return value;
  return "";
}

SampleListing listing_of(const fs::path& folder) {
  const auto listing = read_sample_listing(folder);
  if (!listing)
    throw InputError(folder.string(), "", "has no render.json: it is not finished, or holds no samples",
                     "give the render or produce command again");
  return *listing;
}

/// The views that are there are those that are listed.
void check_whole(const fs::path& folder, const SampleListing& listing) {
  std::set<std::string> there;
  for (const auto& entry : fs::directory_iterator(folder))
    if (is_view_file(entry.path())) there.insert(entry.path().filename().string());
  for (const std::string& view : listing.views) {
    if (!is_view_file(view) || fs::path(view).has_parent_path())
      throw InputError((folder / "render.json").string(), "", "lists '" + view + "', which is no view",
                       "render the folder again");
    if (there.erase(view) == 0)
      throw InputError((folder / view).string(), "", "is missing, and render.json lists it",
                       "render it again");
  }
  if (!there.empty())
    throw InputError((folder / *there.begin()).string(), "",
                     "is not listed by render.json: the folder is not finished, or views are mixed in",
                     "finish it, or move them away");
}

void add_folder(const fs::path& folder, IndexedPerson person, SampleIndex& index) {
  const SampleListing listing = listing_of(folder);
  check_whole(folder, listing);
  if (person.id.empty()) person.id = value_of(listing.settings, "ohb:human");
  if (person.id.empty()) person.id = fs::absolute(folder).filename().string();
  if (person.id.empty() || person.id == "." || person.id == ".." || person.id.find('/') != std::string::npos)
    throw InputError((folder / "render.json").string(), "ohb:human", "'" + person.id + "' names no folder",
                     "render it again with a name");
  for (const IndexedPerson& other : index.people)
    if (other.id == person.id)
      throw InputError(folder.string(), "", "is a second folder of samples of '" + person.id + "'",
                       "export them one by one");
  for (const std::string& view : listing.views) {
    const ExrAttributes attributes = read_sample_attributes(folder / view);
    if (value_of(attributes, "ohb:identity") != listing.identity ||
        identity_of(shared_attributes(attributes)) != listing.identity)
      throw InputError((folder / view).string(), "", "is of other settings than render.json beside it states",
                       "keep views of one setting in a folder, or render it again");
    index.samples.push_back({folder / view, index.people.size(), fs::path(view).stem().string()});
  }
  index.people.push_back(std::move(person));
}

/// The relative path that an attribute states; "" if there is none.
fs::path path_inside(const XmlDocument& xml, pugi::xml_node node, const char* name) {
  const fs::path path = fs::path(xml.text_or(node, name, "")).lexically_normal();
  if (path.is_absolute() || (!path.empty() && *path.begin() == ".."))
    throw xml.error(node, std::string(name) + "=\"" + path.string() + "\" leaves the dataset",
                    "do not use this dataset");
  return path;
}

void add_people_of(const fs::path& root, SampleIndex& index) {
  const XmlDocument xml(root / "dataset.xml", "dataset");
  if (const uint64_t schema = xml.count(xml.root(), "schema", 1000000); schema > kSchema)
    throw xml.error(xml.root(), "is of schema " + std::to_string(schema) + ", newer than 1",
                    "use the version of openhumanbrdf that wrote it");
  index.name = xml.text_or(xml.root(), "name", index.name);
  for (const pugi::xml_node node : xml.child(xml.root(), "people").children("person")) {
    IndexedPerson person;
    person.id = xml.text(node, "id");
    person.split = xml.text(node, "split");
    const fs::path views = path_inside(xml, node, "views"), model = path_inside(xml, node, "model");
    if (views.empty()) throw xml.error(node, "views=\"\" names no folder", "do not use this dataset");
    if (!model.empty()) person.model = root / model;
    const uint64_t sets = xml.count(node, "sets", kMostSets),
                   planned = xml.count(node, "planned_sets", kMostSets);
    if (sets < planned)
      throw xml.error(
          node,
          "'" + person.id + "' has " + std::to_string(sets) + " of " + std::to_string(planned) + " sets",
          "give the produce command again");
    static const std::set<std::string> kNotOfPerson = {
        "id", "split", "model", "views", "model_identity", "sets", "planned_sets"};
    for (const pugi::xml_attribute& attribute : node.attributes())
      if (kNotOfPerson.count(attribute.name()) == 0) person.attributes[attribute.name()] = attribute.value();
    add_folder(root / views, std::move(person), index);
  }
}

}  // namespace

SampleIndex index_samples(const fs::path& folder) {
  if (!fs::is_directory(folder))
    throw InputError(folder.string(), "", fs::exists(folder) ? "is no folder" : "no such folder",
                     "give a folder that render or produce wrote");
  SampleIndex index;
  index.name = fs::absolute(folder).lexically_normal().filename().string();
  if (fs::exists(folder / "dataset.xml")) {
    add_people_of(folder, index);
  } else {
    std::set<fs::path> folders;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
      if (entry.path().filename() == "render.json" || is_view_file(entry.path()))
        folders.insert(entry.path().parent_path());
    for (const fs::path& views : folders) add_folder(views, {}, index);
  }
  if (index.samples.empty())
    throw InputError(folder.string(), "", "holds no samples",
                     "write them with openhumanbrdf render or produce");
  return index;
}

}  // namespace ohb::exports
