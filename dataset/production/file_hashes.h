// Content hashes of inputs, remembered from run to run. A file whose size and time of change are those of the
// last look is taken to be the same; others are read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace ohb::production {

class FileHashes {
 public:
  /// Takes over what `memory` says, if it is there and whole; save() writes it again.
  explicit FileHashes(std::filesystem::path memory);
  /// Takes over what another memory knows, without saving it.
  void learn(const std::filesystem::path& memory);

  /// SHA-256 of the file. Throws InputError if it is missing or cannot be read.
  std::string of(const std::filesystem::path& file);

  /// SHA-256 of everything that a scan is made of: mesh, materials and pictures. The scan is read to find
  /// its files unless those of the last time and their folders are all unchanged. Throws as read_scan.
  std::string of_scan(const std::filesystem::path& scan);

  /// Throws as write_file_atomically. Does nothing if there is nothing new.
  void save();

 private:
  struct Known {
    uint64_t size = 0;
    int64_t changed_ns = 0;
    std::string sha256;
  };
  bool is_unchanged(const std::string& file) const;
  /// A folder of which nothing but a change counts.
  void watch(const std::string& folder);

  std::filesystem::path memory_;
  std::map<std::string, Known> files_;
  std::map<std::string, std::vector<std::string>> scans_;  // the files of each
  bool is_new_ = false;
};

}  // namespace ohb::production
