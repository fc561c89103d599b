// Every reader of the dataset's programs, with valid input for it.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace ohb {

struct FuzzedReader {
  std::string name;
  /// Valid input: names below a folder, and bytes. The first `mutated` of them are damaged, one an input.
  std::vector<std::pair<std::string, std::string>> files;
  size_t mutated = 1;
  /// Reads what is in the folder. May throw InputError and nothing else.
  std::function<void(const std::filesystem::path& folder)> read;
};

/// `scratch`: an empty folder in which valid files may be made.
std::vector<FuzzedReader> fuzzed_readers(const std::filesystem::path& scratch);

}  // namespace ohb
