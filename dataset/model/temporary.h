// Temporary names of outputs. Each is locked as long as its writer lives, so that what a killed command left
// behind is told from what another one is writing, whatever process ids are used again.
#pragma once

#include <filesystem>
#include <optional>

#include "dataset/model/interrupt.h"

namespace ohb {

/// A new empty file or folder `.<name>.<process>-<n>.tmp<extension>` beside `target`. A file keeps the
/// target's extension (writers choose the format by it). The destructor removes what is there of that name
/// by then. Throws InputError (folder missing, no permission) or TryAgainError (disk full).
class LockedTemporary {
 public:
  enum class Kind { kFile, kFolder };
  LockedTemporary(const std::filesystem::path& target, Kind kind);
  ~LockedTemporary();
  LockedTemporary(const LockedTemporary&) = delete;
  LockedTemporary& operator=(const LockedTemporary&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  std::optional<Unfinished> unfinished_;  // of path_
  int handle_ = -1;                       // holds the lock
};

/// Removes the temporaries in `folder` whose writers are dead. A folder that was moved aside by a command
/// that was killed before it put the new one in its place is moved back. Never throws; where the file system
/// knows no locks nothing is removed.
void sweep_leftovers(const std::filesystem::path& folder) noexcept;
/// The same, once a folder and process: for writers of many files.
void sweep_leftovers_once(const std::filesystem::path& folder) noexcept;

/// `fresh` takes the place of the folder `old`, without a moment in which neither is there; what was at `old`
/// is at `fresh` then. On file systems that cannot exchange two names, by replace_in_two_steps.
/// Throws as LockedTemporary.
void replace_folder(const std::filesystem::path& fresh, const std::filesystem::path& old);
/// `old` steps aside to `.<name>.<process>-<n>.old` and is removed once `fresh` is in its place;
/// sweep_leftovers puts it back if we are killed in between.
void replace_in_two_steps(const std::filesystem::path& fresh, const std::filesystem::path& old);

/// The folder that a file or folder is in; "." for a bare name.
std::filesystem::path folder_of(const std::filesystem::path& path);

/// Where a link points to, at last; other paths as they are.
std::filesystem::path followed(const std::filesystem::path& path);

/// Makes what is on disk of a file or folder (its entries) survive a power cut. Throws as LockedTemporary.
void sync_path(const std::filesystem::path& path, bool is_folder);

/// InputError or, for a full disk, TryAgainError: "<file>: cannot be written: <error>".
[[noreturn]] void throw_write_error(const std::filesystem::path& file, int error);

}  // namespace ohb
