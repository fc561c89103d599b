// Units of work and their markers. A unit (a person's label, bake, or one set of images) is done if its
// marker is there, names the hash of everything that the unit is made from, and each of its files has the
// size that the marker says. The marker goes before its files are replaced and comes after they are safely on
// disk.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dataset/production/layout.h"

namespace ohb::production {

struct UnitFile {
  std::string path;  // relative to the dataset's folder, '/'
  uint64_t size = 0;
  std::string sha256;
};

struct UnitMarker {
  std::string hash;                          // of inputs' content, settings and version
  std::map<std::string, std::string> facts;  // what later stages ask: "identity" of a model
  std::vector<UnitFile> files;
};

/// None if there is no such marker, or if it is damaged: then the unit is made again.
std::optional<UnitMarker> read_marker(const Layout& layout, const std::string& id, const std::string& unit);

/// The marker, if the unit is done with that hash.
std::optional<UnitMarker> done_marker(const Layout& layout, const std::string& id, const std::string& unit,
                                      const std::string& hash);

/// Before the unit's files are replaced: from here on it is not done. Safe against power cuts.
void begin_unit(const Layout& layout, const std::string& id, const std::string& unit);

/// After its files are in place. `files` are paths below the dataset's folder; their sizes and hashes are
/// taken here. Throws TryAgainError for a full disk.
void finish_unit(const Layout& layout, const std::string& id, const std::string& unit,
                 const std::vector<std::filesystem::path>& files, UnitMarker marker);

/// Names of a person's units that have a marker, sorted.
std::vector<std::string> marked_units(const Layout& layout, const std::string& id);

/// SHA-256 of named texts, in this order.
std::string hash_of_parts(const std::vector<std::pair<std::string, std::string>>& parts);

}  // namespace ohb::production
