#include "dataset/production/units.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"
#include "dataset/model/temporary.h"

namespace ohb::production {
namespace fs = std::filesystem;
namespace {

std::string padded(int number) {
  const std::string digits = std::to_string(number);
  return std::string(digits.size() < 3 ? 3 - digits.size() : 0, '0') + digits;
}

/// Whether it leads to no other place than into the dataset.
bool stays_inside(const fs::path& path) {
  const fs::path normal = path.lexically_normal();
  return !normal.empty() && !normal.has_root_path() && *normal.begin() != "..";
}

}  // namespace

std::string set_file(int number) {
  return "view_" + padded(number) + ".exr";
}

std::string set_unit(int number) {
  return "set_" + padded(number);
}

std::optional<UnitMarker> read_marker(const Layout& layout, const std::string& id, const std::string& unit) {
  const fs::path file = layout.marker(id, unit);
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return std::nullopt;
  try {
    const nlohmann::json json = read_json(file);
    UnitMarker marker;
    marker.hash = json.at("hash").get<std::string>();
    marker.facts = json.at("facts").get<std::map<std::string, std::string>>();
    for (const auto& row : json.at("files"))
      marker.files.push_back({row.at("path").get<std::string>(), row.at("size").get<uint64_t>(),
                              row.at("sha256").get<std::string>()});
    // Files that a marker names are removed when the plan drops the unit: none but the dataset's.
    for (const UnitFile& entry : marker.files)
      if (!stays_inside(entry.path)) return std::nullopt;
    return marker;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

std::optional<UnitMarker> done_marker(const Layout& layout, const std::string& id, const std::string& unit,
                                      const std::string& hash) {
  std::optional<UnitMarker> marker = read_marker(layout, id, unit);
  if (!marker || marker->hash != hash) return std::nullopt;
  for (const UnitFile& file : marker->files) {
    std::error_code error;
    if (fs::file_size(layout.root / file.path, error) != file.size || error) return std::nullopt;
  }
  return marker;
}

void begin_unit(const Layout& layout, const std::string& id, const std::string& unit) {
  const fs::path file = layout.marker(id, unit);
  std::error_code error;
  if (!fs::remove(file, error) && !error) return;
  if (error) throw_write_error(file, error.value());
  sync_path(folder_of(file), true);
}

void finish_unit(const Layout& layout, const std::string& id, const std::string& unit,
                 const std::vector<fs::path>& files, UnitMarker marker) {
  nlohmann::ordered_json json = {
      {"hash", marker.hash}, {"facts", marker.facts}, {"files", nlohmann::json::array()}};
  for (const fs::path& file : files)
    json["files"].push_back({{"path", file.lexically_relative(layout.root).generic_string()},
                             {"size", fs::file_size(file)},
                             {"sha256", sha256_of_file(file)}});
  make_folders(layout.done(id));
  write_file_atomically(layout.marker(id, unit), json_text(json, 1) + "\n");
}

std::vector<std::string> marked_units(const Layout& layout, const std::string& id) {
  std::vector<std::string> units;
  std::error_code ignored;
  for (fs::directory_iterator entry(layout.done(id), ignored), end; !ignored && entry != end;
       entry.increment(ignored))
    if (entry->path().extension() == ".json" && entry->path().filename().string()[0] != '.')
      units.push_back(entry->path().stem().string());
  std::sort(units.begin(), units.end());
  return units;
}

std::string hash_of_parts(const std::vector<std::pair<std::string, std::string>>& parts) {
  std::string text;
  for (const auto& [name, value] : parts)
    text.append(name + " ").append(std::to_string(value.size())).append(" " + value + "\n");
  return sha256_of(text);
}

}  // namespace ohb::production
