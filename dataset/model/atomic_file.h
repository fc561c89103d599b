// Outputs appear whole or not at all: written to a temporary name in the same folder, synced, renamed.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace ohb {

/// Calls `write(temporary)`, syncs what it wrote and renames it to `file` (replacing an older one).
/// The temporary name keeps the extension (writers choose the format by it). It is removed if anything
/// throws. Throws InputError (folder missing, no permission) or TryAgainError (disk full).
void write_file_atomically(const std::filesystem::path& file,
                           const std::function<void(const std::filesystem::path& temporary)>& write);

/// The same for text or bytes at hand.
void write_file_atomically(const std::filesystem::path& file, const std::string& content);

/// An output folder that appears whole: fill path(), then commit(). Without commit the destructor removes it.
/// An existing folder of that name is replaced at commit only if it carries the marker file that
/// commit writes (".openhumanbrdf"), so that a user's own folder is never deleted: then InputError.
class AtomicFolder {
 public:
  explicit AtomicFolder(const std::filesystem::path& folder);
  ~AtomicFolder();
  AtomicFolder(const AtomicFolder&) = delete;
  AtomicFolder& operator=(const AtomicFolder&) = delete;

  const std::filesystem::path& path() const { return temporary_; }
  void commit();

 private:
  std::filesystem::path folder_, temporary_;
  bool committed_ = false;
};

/// Makes a folder and those above it, if they are not there. Throws as write_file_atomically.
void make_folders(const std::filesystem::path& folder);

/// The whole file as bytes. Throws InputError if it does not exist or cannot be read.
std::string read_file(const std::filesystem::path& file);

/// SHA-256 of a file's bytes as 64 hexadecimal digits. Throws as read_file.
std::string sha256_of_file(const std::filesystem::path& file);

}  // namespace ohb
