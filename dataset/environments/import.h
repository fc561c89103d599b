// environments import: panoramas as people have them, into a library.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "dataset/environments/library.h"

namespace ohb::environments {

struct ImportJob {
  std::vector<std::filesystem::path> files;
  std::filesystem::path library;
  int width_px = 0;             // 0: the picture's own, at most kOwnWidth_px
  std::string licence, source;  // of files without a sidecar that says otherwise
  bool quiet = false;
};

constexpr int kOwnWidth_px = 4096;

/// What a library was given, by import or synthesise.
struct LibraryChange {
  struct Item {
    LibraryEntry entry;
    bool was_there = false;
  };
  std::vector<Item> items;
  double seconds = 0;
};

/// FILE.json ("studio.hdr.json"), or the file's name with .json instead ("studio.json"), may state "licence"
/// and "source". Files that cannot be used are named on stderr, a line each, the others are imported; then
/// InputError is thrown. A file whose content is in the library at that width is left as it is.
/// Throws InputError: a file that cannot be used (read_panorama), that has no licence, the library;
/// TryAgainError: disk full, SIGINT or SIGTERM (finished maps stay).
LibraryChange import_environments(const ImportJob& job);

nlohmann::json to_json(const LibraryEntry& entry);
nlohmann::json to_json(const LibraryChange& change);

}  // namespace ohb::environments
