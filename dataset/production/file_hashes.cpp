#include "dataset/production/file_hashes.h"

#include <sys/stat.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "dataset/commands/picture_files.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"
#include "dataset/model/temporary.h"

namespace ohb::production {
namespace fs = std::filesystem;
namespace {

/// Size and time of the last change in ns; false if there is no such file. Not the time of modification,
/// which whoever copies or unpacks a file sets as he likes.
bool look_at(const std::string& file, uint64_t& size, int64_t& changed_ns) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return false;
  size = static_cast<uint64_t>(status.st_size);
  changed_ns = int64_t{status.st_ctim.tv_sec} * 1000000000 + status.st_ctim.tv_nsec;
  return true;
}

/// What may be looked at of a folder.
std::vector<fs::path> paths_in(const fs::path& folder) {
  std::vector<fs::path> paths;
  std::error_code ignored;
  for (fs::directory_iterator entry(folder, ignored), end; !ignored && entry != end; entry.increment(ignored))
    paths.push_back(entry->path());
  return paths;
}

bool is_of_materials(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  std::error_code ignored;
  return (extension == ".mtl" || extension == ".bin") && fs::is_regular_file(path, ignored);
}

/// Mesh and pictures, the folders where readers look for files, and every material and buffer file there:
/// readers find these by many names. A folder changes when a name in it comes or goes.
std::vector<std::string> files_of_scan(const fs::path& file) {
  std::set<fs::path> files{fs::absolute(file).lexically_normal()}, folders;
  for (const fs::path& picture : commands::picture_files(read_scan(file)))
    files.insert(fs::absolute(picture).lexically_normal());
  for (const fs::path& known : files) folders.insert(folder_of(known));
  std::error_code ignored;
  for (const fs::path& path : paths_in(folder_of(fs::absolute(file).lexically_normal())))
    if (fs::is_directory(path, ignored)) folders.insert(path);
  for (const fs::path& folder : folders)
    for (const fs::path& path : paths_in(folder))
      if (is_of_materials(path)) files.insert(path);
  std::vector<std::string> all;
  for (const auto* paths : {&files, &folders})
    for (const fs::path& path : *paths) all.push_back(path.string());
  return all;
}

}  // namespace

FileHashes::FileHashes(fs::path memory) : memory_(std::move(memory)) {
  learn(memory_);
}

void FileHashes::learn(const fs::path& memory) {
  std::error_code ignored;
  if (!fs::is_regular_file(memory, ignored)) return;
  try {
    const nlohmann::json json = read_json(memory, kListingLimits);
    for (const auto& [file, row] : json.at("files").items())
      files_[file] = {row.at(0).get<uint64_t>(), row.at(1).get<int64_t>(), row.at(2).get<std::string>()};
    for (const auto& [scan, files] : json.at("scans").items())
      scans_[scan] = files.get<std::vector<std::string>>();
  } catch (const nlohmann::json::exception&) {
    // Damaged: what it knew is found out again.
  } catch (const InputError&) {
  }
}

bool FileHashes::is_unchanged(const std::string& file) const {
  const auto known = files_.find(file);
  uint64_t size = 0;
  int64_t changed_ns = 0;
  return known != files_.end() && look_at(file, size, changed_ns) && size == known->second.size &&
         changed_ns == known->second.changed_ns;
}

std::string FileHashes::of(const fs::path& given) {
  const std::string file = fs::absolute(given).lexically_normal().string();
  if (is_unchanged(file)) return files_[file].sha256;
  Known known;
  look_at(file, known.size, known.changed_ns);
  known.sha256 = sha256_of_file(given);
  files_[file] = known;
  is_new_ = true;
  return known.sha256;
}

void FileHashes::watch(const std::string& folder) {
  if (is_unchanged(folder)) return;
  Known known;
  look_at(folder, known.size, known.changed_ns);
  files_[folder] = known;
  is_new_ = true;
}

std::string FileHashes::of_scan(const fs::path& scan) {
  const std::string key = fs::absolute(scan).lexically_normal().string();
  std::vector<std::string>& files = scans_[key];
  if (files.empty() ||
      !std::all_of(files.begin(), files.end(), [&](const auto& f) { return is_unchanged(f); })) {
    files = files_of_scan(scan);
    is_new_ = true;
  }
  // Names count by their place beside the scan, so that a moved folder is the same scan.
  std::string text;
  for (const std::string& file : files)
    if (std::error_code ignored; fs::is_directory(file, ignored))
      watch(file);
    else
      text += fs::path(file).lexically_proximate(folder_of(key)).generic_string() + " " + of(file) + "\n";
  return sha256_of(text);
}

void FileHashes::save() {
  if (!is_new_) return;
  nlohmann::json json = {{"files", nlohmann::json::object()}, {"scans", scans_}};
  for (const auto& [file, known] : files_) json["files"][file] = {known.size, known.changed_ns, known.sha256};
  make_folders(folder_of(memory_));
  write_file_atomically(memory_, json_text(json, 1) + "\n");
  is_new_ = false;
}

}  // namespace ohb::production
