// Output folders: each says in its marker file (".openhumanbrdf") what it is and which files belong to it, so
// that a command replaces nothing but what the same command wrote.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dataset/model/temporary.h"

namespace ohb {

/// What the marker of a folder says.
struct FolderMarker {
  std::string kind;                // "model", "regions", ...; "" in those of versions before kinds
  std::vector<std::string> files;  // relative paths; empty for folders that grow (claim_folder)
};
/// None if there is no marker.
std::optional<FolderMarker> read_marker(const std::filesystem::path& folder);

/// An output folder that appears whole: fill path(), then commit(). Without commit the destructor removes it.
/// A folder that is there already is replaced at commit, without a moment in which neither is there, if it is
/// empty or if its marker is of the same kind, every file in it is one that the marker lists, and none of the
/// command's inputs lies in it. A link to a folder is followed: what it points to is replaced.
class AtomicFolder {
 public:
  /// Throws InputError: a folder that may not be replaced, with the first file that speaks against it; no
  /// permission. TryAgainError: disk full.
  AtomicFolder(const std::filesystem::path& folder, std::string kind,
               const std::vector<std::filesystem::path>& inputs = {});

  const std::filesystem::path& path() const { return temporary_->path(); }
  /// Further inputs, known only now. Empty paths, and what does not exist, count for nothing.
  void protect(const std::vector<std::filesystem::path>& inputs) const;
  /// Lists the files in the marker, syncs them and puts the folder in its place. Throws as the constructor.
  void commit();

 private:
  std::filesystem::path folder_;
  std::string kind_;
  std::optional<LockedTemporary> temporary_;
};

/// Throws InputError if `file` is listed in the marker of a folder above it: a command that writes one file
/// must not spoil another output.
void check_not_owned(const std::filesystem::path& file);

/// Makes a folder that grows from run to run (samples, training runs) and marks it with its kind. Throws
/// InputError if it is marked as another kind, holds files and no mark, or cannot be made; TryAgainError if
/// the disk is full.
void claim_folder(const std::filesystem::path& folder, const std::string& kind);

}  // namespace ohb
