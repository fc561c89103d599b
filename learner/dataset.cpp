// The index of a dataset: which views belong to whom.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/sample_listing.h"
#include "learner/data.h"

namespace ohb::learner {
namespace fs = std::filesystem;
namespace {

bool is_view(const fs::path& file) {
  return file.extension() == ".exr" && file.filename().string().rfind("view_", 0) == 0;
}

std::string value_of(const ExrAttributes& attributes, const std::string& name) {
  for (const auto& [key, value] : attributes)
    if (key == name) return value;
  return "";
}

/// The name of the first attribute that two views of one folder do not share.
std::string first_difference(const ExrAttributes& a, const ExrAttributes& b) {
  const std::map<std::string, std::string> left(a.begin(), a.end()), right(b.begin(), b.end());
  for (const auto* side : {&left, &right})
    for (const auto& [name, value] : *side) {
      const auto other = (side == &left ? right : left).find(name);
      if (other == (side == &left ? right : left).end() || other->second != value) return name;
    }
  return "";
}

struct View {
  fs::path file;
  ExrAttributes attributes;
};

/// Those that render.json lists and that are of its settings. The others are named, and left out.
std::vector<View> belonging(std::vector<View> views, const SampleListing& listing, const fs::path& folder) {
  std::vector<std::string> strays;
  std::vector<View> ours;
  for (View& view : views) {
    const std::string name = view.file.filename().string();
    const bool is_listed = std::binary_search(listing.views.begin(), listing.views.end(), name);
    if (is_listed && identity_of(shared_attributes(view.attributes)) == listing.identity)
      ours.push_back(std::move(view));
    else
      strays.push_back(name);
  }
  if (!strays.empty())
    spdlog::warn("{}: {} of its view files {} not of the samples that render.json lists and {} left out: {}",
                 folder.string(), strays.size(), strays.size() == 1 ? "is" : "are",
                 strays.size() == 1 ? "is" : "are", fmt::join(strays, ", "));
  return ours;
}

void check_agreement(const std::vector<View>& views) {
  const ExrAttributes first = shared_attributes(views.front().attributes);
  for (const View& view : views)
    if (const std::string name = first_difference(first, shared_attributes(view.attributes)); !name.empty())
      throw InputError(view.file.string(), "attribute " + name,
                       "is another than that of " + views.front().file.filename().string() +
                           " beside it: they are of different settings",
                       "keep views of one setting in a folder, or render them again");
}

std::vector<View> views_in(const fs::path& folder, std::vector<fs::path> files) {
  std::sort(files.begin(), files.end());
  std::vector<View> views;
  const std::optional<SampleListing> listing = read_sample_listing(folder);
  for (const fs::path& file : files) {
    // What render.json does not list need not be a sample at all.
    const bool is_listed = !listing || std::binary_search(listing->views.begin(), listing->views.end(),
                                                          file.filename().string());
    // Of a broken file the whole reader tells more.
    if (views.empty() && is_listed) read_sample(file);
    views.push_back({file, is_listed ? read_sample_attributes(file) : ExrAttributes()});
  }
  if (listing) return belonging(std::move(views), *listing, folder);
  check_agreement(views);
  return views;
}

}  // namespace

Dataset read_dataset(const fs::path& folder) {
  if (!fs::is_directory(folder))
    throw InputError(folder.string(), "", fs::exists(folder) ? "is no folder" : "no such folder",
                     "give the folder that holds one folder of views a person");
  std::map<fs::path, std::vector<fs::path>> by_folder;
  for (const auto& entry :
       fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied))
    if (entry.is_regular_file() && is_view(entry.path()))
      by_folder[entry.path().parent_path()].push_back(entry.path());
  std::map<std::string, Person> people;
  for (auto& [parent, files] : by_folder)
    for (const View& view : views_in(parent, files)) {
      std::string name = value_of(view.attributes, "ohb:human");
      if (name.empty()) name = fs::absolute(view.file).parent_path().filename().string();
      Person& person = people[name];
      person.name = name;
      person.views.push_back(view.file);
      person.identities.push_back(identity_of(view.attributes));
    }
  if (people.empty())
    throw InputError(folder.string(), "", "holds no view_*.exr", "write them with: openhumanbrdf render");
  Dataset dataset{folder, {}};
  for (auto& [name, person] : people) dataset.people.push_back(std::move(person));
  return dataset;
}

std::string identity_of_views(const Dataset& dataset, const std::vector<std::string>& people) {
  std::string text;
  for (const Person& person : dataset.people)
    if (std::find(people.begin(), people.end(), person.name) != people.end())
      for (size_t i = 0; i < person.views.size(); ++i)
        text +=
            person.name + "\t" + person.views[i].filename().string() + "\t" + person.identities.at(i) + "\n";
  return sha256_of(text);
}

std::vector<fs::path> views_of(const Dataset& dataset, const std::vector<std::string>& people) {
  std::vector<fs::path> views;
  for (const Person& person : dataset.people)
    if (std::find(people.begin(), people.end(), person.name) != people.end())
      views.insert(views.end(), person.views.begin(), person.views.end());
  return views;
}

}  // namespace ohb::learner
