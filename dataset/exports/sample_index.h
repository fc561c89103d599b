// Which samples a folder holds: one that `render` wrote, a folder of such, or a dataset that `produce` wrote.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace ohb::exports {

struct IndexedPerson {
  std::string id;                                 // names a folder: no '/', not "." or ".."
  std::string split;                              // "" where there is no dataset.xml
  std::map<std::string, std::string> attributes;  // sex, age, licence, ... as dataset.xml states them
  std::filesystem::path model;  // folder of the baked model; "" where there is no dataset.xml
};

struct IndexedSample {
  std::filesystem::path file;
  size_t person = 0;  // of SampleIndex::people
  std::string view;   // "view_007"
};

struct SampleIndex {
  std::string name;  // of the dataset
  std::vector<IndexedPerson> people;
  std::vector<IndexedSample> samples;  // by person, then by view
};

/// Only views that render.json lists. Throws InputError: no samples; a view that is missing, not listed or of
/// other settings; people whose sets are not finished; two folders of one person; a dataset of a newer
/// schema; paths that leave the folder.
SampleIndex index_samples(const std::filesystem::path& folder);

}  // namespace ohb::exports
