// The optional humans and scans (CMake cache variable OHB_SHARED_DATA).
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "tests/support/paths.h"

namespace ohb {

/// A folder of the optional data; empty if it is not on this machine.
inline std::filesystem::path shared_data(const std::string& folder) {
  const std::filesystem::path path = shared_data_path(folder);
  return std::filesystem::is_directory(path) ? path : std::filesystem::path();
}

/// Every .obj below the folder, sorted.
inline std::vector<std::filesystem::path> objs_below(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".obj") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// Skips the test if the folder is not there, and only then.
#define OHB_SHARED_DATA_OR_SKIP(variable, folder)             \
  const std::filesystem::path variable = shared_data(folder); \
  if (variable.empty()) GTEST_SKIP() << "not there: " << shared_data_path(folder)

}  // namespace ohb
