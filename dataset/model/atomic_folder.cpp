#include "dataset/model/atomic_folder.h"

#include <algorithm>
#include <cerrno>
#include <set>
#include <sstream>
#include <system_error>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"

namespace ohb {
namespace fs = std::filesystem;
namespace {

constexpr const char* kMarkerName = ".openhumanbrdf";
constexpr const char *kKind = "kind ", *kFile = "file ";
constexpr const char* kMend = "choose another -o, or remove it yourself";

std::string marker_text(const std::string& kind, const std::vector<std::string>& files) {
  std::string text = "written by openhumanbrdf " OHB_VERSION "\n" + (kKind + kind) + "\n";
  for (const std::string& file : files) text += kFile + file + "\n";
  return text;
}

/// All but folders, relative, sorted; the marker is left out.
std::vector<std::string> files_below(const fs::path& folder) {
  std::vector<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (!fs::is_directory(entry.symlink_status()))
      files.push_back(entry.path().lexically_relative(folder).generic_string());
  files.erase(std::remove(files.begin(), files.end(), kMarkerName), files.end());
  std::sort(files.begin(), files.end());
  return files;
}

/// Folders that hold none of these files, however deep: somebody made them.
std::vector<std::string> foreign_folders(const fs::path& folder, const std::vector<std::string>& files) {
  std::set<std::string> ours;
  for (const std::string& file : files)
    for (fs::path up = fs::path(file).parent_path(); !up.empty(); up = up.parent_path())
      ours.insert(up.generic_string());
  std::vector<std::string> foreign;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).generic_string();
    if (fs::is_directory(entry.symlink_status()) && ours.count(name) == 0) foreign.push_back(name + "/");
  }
  return foreign;
}

void check_kind(const fs::path& folder, const FolderMarker& marker, const std::string& kind) {
  if (marker.kind.empty())
    throw InputError(folder.string(), "", "was written by an older version, which did not list its files",
                     kMend);
  if (marker.kind != kind)
    throw InputError(folder.string(), "",
                     "holds " + marker.kind + ", and " + kind + " would be written there", kMend);
}

/// Throws InputError unless `folder` may be replaced by one of that kind.
void check_replaceable(const fs::path& folder, const std::string& kind) {
  const fs::file_status status = fs::symlink_status(folder);
  if (!fs::exists(status)) return;
  if (!fs::is_directory(status))
    throw InputError(folder.string(), "", "is a file, a folder should be written there", "choose another -o");
  if (fs::is_empty(folder)) return;
  const std::optional<FolderMarker> marker = read_marker(folder);
  if (!marker)
    throw InputError(folder.string(), "", "exists and was not written by this program",
                     "choose another -o or remove it yourself");
  check_kind(folder, *marker, kind);
  std::vector<std::string> foreign = foreign_folders(folder, marker->files);
  for (const std::string& file : files_below(folder))
    if (!std::binary_search(marker->files.begin(), marker->files.end(), file)) foreign.push_back(file);
  if (foreign.empty()) return;
  std::sort(foreign.begin(), foreign.end());
  throw InputError(folder.string(), "",
                   "would be replaced, and holds '" + foreign[0] + "'" +
                       (foreign.size() > 1 ? " and " + std::to_string(foreign.size() - 1) + " more" : "") +
                       ", not written by this program",
                   "move what you want to keep, or choose another -o");
}

/// A name that is not hidden, or "": hidden ones are none of ours, and a killed run may have left some.
std::string open_name_in(const fs::path& folder) {
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (const std::string name = entry->path().filename().string(); name[0] != '.') return name;
  return "";
}

bool is_below(const fs::path& path, const fs::path& folder) {
  const auto [end, ignored] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  return end == folder.end();
}

/// What a file system cannot do (no permission to look into a folder) is the user's to mend.
template <typename Action>
auto in_words(const fs::path& folder, const Action& action) {
  try {
    return action();
  } catch (const fs::filesystem_error& error) {
    throw_write_error(folder, error.code().value());
  }
}

fs::path target_of(const fs::path& given) {
  // "out/" and "out" are one folder; "." and ".." have names.
  fs::path folder = given.has_filename() ? given : given.parent_path();
  if (folder.empty()) throw InputError("", "-o", "names no folder", "give the folder to write");
  folder = followed(folder);
  if (folder.filename() == "." || folder.filename() == "..") folder = fs::canonical(folder);
  std::error_code ignored;
  if (!folder.has_filename() || fs::equivalent(folder, fs::current_path(ignored), ignored))
    throw InputError(folder.string(), "-o", "is the folder that the command runs in, or the root",
                     "name a folder inside of it");
  return folder;
}

}  // namespace

std::optional<FolderMarker> read_marker(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::is_regular_file(folder / kMarkerName, ignored)) return std::nullopt;
  FolderMarker marker;
  std::istringstream lines(read_file(folder / kMarkerName));
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind(kKind, 0) == 0) marker.kind = line.substr(std::string(kKind).size());
    if (line.rfind(kFile, 0) == 0) marker.files.push_back(line.substr(std::string(kFile).size()));
  }
  std::sort(marker.files.begin(), marker.files.end());
  return marker;
}

AtomicFolder::AtomicFolder(const fs::path& folder, std::string kind, const std::vector<fs::path>& inputs)
    : kind_(std::move(kind)) {
  in_words(folder, [&] {
    folder_ = target_of(folder);
    make_folders(folder_of(folder_));
    sweep_leftovers(folder_of(folder_));
    check_replaceable(folder_, kind_);
    protect(inputs);
  });
  temporary_.emplace(folder_, LockedTemporary::Kind::kFolder);
}

void AtomicFolder::protect(const std::vector<fs::path>& inputs) const {
  std::error_code error;
  const fs::path here = fs::canonical(folder_, error);
  if (error) return;  // nothing is there yet
  for (const fs::path& input : inputs) {
    const fs::path there = fs::canonical(input, error);
    if (!input.empty() && !error && is_below(there, here))
      throw InputError(folder_.string(), "-o",
                       "would be replaced, and " + input.string() + ", which this command reads, is in it",
                       "choose another -o");
  }
}

void AtomicFolder::commit() {
  in_words(folder_, [&] {
    // Somebody may have put a file there since the constructor looked.
    check_replaceable(folder_, kind_);
    const std::vector<std::string> files = files_below(path());
    for (const std::string& file : files) sync_path(path() / file, false);
    write_file_atomically(path() / kMarkerName, marker_text(kind_, files));
    if (fs::exists(folder_)) {
      replace_folder(path(), folder_);
      return;
    }
    hold_off_ending([&] { fs::rename(path(), folder_); });
    sync_path(folder_of(folder_), true);
  });
  temporary_.reset();
}

void check_not_owned(const fs::path& file) {
  std::error_code error;
  const fs::path whole = fs::weakly_canonical(file, error);
  if (error) return;
  for (fs::path up = whole.parent_path(); up.has_relative_path(); up = up.parent_path()) {
    const std::optional<FolderMarker> marker = read_marker(up);
    if (marker && std::binary_search(marker->files.begin(), marker->files.end(),
                                     whole.lexically_relative(up).generic_string()))
      throw InputError(file.string(), "-o", "belongs to the " + marker->kind + " in " + up.string(),
                       "choose another name");
  }
}

void claim_folder(const fs::path& folder, const std::string& kind) {
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_directory(folder, error))
    throw InputError(folder.string(), "", "is a file, a folder should be written there", "choose another -o");
  // Before the marker, which those who start at the same time write before anything else.
  const std::string foreign = open_name_in(folder);
  if (const std::optional<FolderMarker> marker = read_marker(folder)) {
    check_kind(folder, *marker, kind);
    return;
  }
  if (!foreign.empty())
    throw InputError(folder.string(), "", "holds '" + foreign + "', and was not written by this program",
                     "choose another -o, or a new folder inside of it");
  make_folders(folder);
  write_file_atomically(folder / kMarkerName, marker_text(kind, {}));
}

}  // namespace ohb
