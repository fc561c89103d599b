#include "dataset/model/scan_files.h"

#include <algorithm>
#include <limits>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/file_names.h"
#include "dataset/model/scan_readers.h"
#include "dataset/model/text_lines.h"

namespace ohb {
namespace fs = std::filesystem;
namespace {

/// So many last parts of a path that another machine wrote are looked for at most.
constexpr size_t kMaxParts = 8;

const std::vector<std::string> kPictureExtensions{".png", ".jpg", ".jpeg", ".tif", ".tiff", ".exr",  ".hdr",
                                                  ".tga", ".bmp", ".dds",  ".psd", ".gif",  ".webp", ".jp2"};

/// Folders in which exporters and those who pack scans put pictures.
bool is_usual_folder(const std::string& reading, const std::string& scan_stem) {
  for (const char* usual : {"textures", "texture", "tex", "images", "image", "img", "maps", "map",
                            "materials", "material", "pictures", "pics", "bitmaps", "photos", "sourceimages"})
    if (reading == usual) return true;
  const std::vector<std::string> stem = name_readings(scan_stem);
  if (stem.empty()) return false;
  for (const char* ending : {".fbm", "", "_textures", "_texture", "_tex", "_files"})
    if (reading == stem[0] + ending) return true;
  return false;
}

/// Without what surrounds a name in files that people edit: quotes, blanks, a NUL and what follows it.
std::string cleaned(std::string_view name) {
  name = trimmed(name.substr(0, name.find('\0')));
  while (name.size() > 1 && (name.front() == '"' || name.front() == '\'') && name.back() == name.front())
    name = trimmed(name.substr(1, name.size() - 2));
  return std::string(name);
}

std::string with_slashes(std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  return name;
}

std::vector<std::string> parts_of(const std::string& portable) {
  std::vector<std::string> parts;
  for (size_t at = 0; at <= portable.size();) {
    const size_t slash = std::min(portable.find('/', at), portable.size());
    const std::string part = portable.substr(at, slash - at);
    if (!part.empty() && part != ".") parts.push_back(part);
    at = slash + 1;
  }
  return parts;
}

bool is_file(const fs::path& file) {
  std::error_code error;
  return fs::is_regular_file(file, error);
}

bool ends_in(const std::string& reading, const std::vector<std::string>& extensions) {
  return std::any_of(extensions.begin(), extensions.end(), [&](const std::string& ending) {
    return reading.size() > ending.size() &&
           reading.compare(reading.size() - ending.size(), ending.size(), ending) == 0;
  });
}

}  // namespace

const std::vector<ScanFiles::Entry>& ScanFiles::entries(const fs::path& folder) {
  const auto [at, is_new] = entries_.try_emplace(folder);
  if (!is_new) return at->second;
  std::error_code error, status_error;
  fs::directory_iterator item(folder, error);
  for (; !error && item != fs::directory_iterator() && at->second.size() < kMaxEntries;
       item.increment(error)) {
    const std::string name = item->path().filename().string();
    at->second.push_back({name, name_readings(name), item->is_directory(status_error)});
  }
  std::sort(at->second.begin(), at->second.end(),
            [](const Entry& a, const Entry& b) { return a.name < b.name; });
  return at->second;
}

ScanFiles::Found ScanFiles::find_in(const fs::path& folder, const std::string& name, bool is_folder) {
  std::error_code error;
  if (is_folder ? fs::is_directory(folder / name, error) : is_file(folder / name))
    return {folder / name, {}, false};
  std::vector<fs::path> fit, fit_surely;  // surely: in the reading that both state, not in a guessed one
  std::string first_tile;
  std::vector<std::string> wanted = name_readings(name);
  for (const Entry& entry : entries(folder)) {
    const std::string of_tile = with_udim_tile_of(name, entry.name);
    if (of_tile != name) {
      if (!first_tile.empty() && of_tile != first_tile) continue;  // sorted: the first tile that fits counts
      wanted = name_readings(of_tile);
    }
    if (entry.is_folder != is_folder || !share_a_reading(entry.readings, wanted)) continue;
    if (of_tile != name) first_tile = of_tile;
    fit.push_back(folder / entry.name);
    if (entry.readings[0] == wanted[0]) fit_surely.push_back(folder / entry.name);
  }
  if (!fit_surely.empty()) fit = fit_surely;
  if (fit.empty()) return {};
  return {fit[0], {fit.begin() + 1, fit.end()}, false};
}

/// From `folder` part by part, ".." included, then without the first part, and so on.
ScanFiles::Found ScanFiles::find_by_path(const fs::path& folder, const std::vector<std::string>& parts) {
  for (size_t first = parts.size() > kMaxParts ? parts.size() - kMaxParts : 0; first < parts.size();
       ++first) {
    Found here{folder, {}, false};
    for (size_t i = first; i < parts.size() && !here.file.empty(); ++i)
      here = parts[i] == ".." ? Found{here.file.lexically_normal() / "..", {}, false}
                              : find_in(here.file, parts[i], i + 1 < parts.size());
    if (here.file.empty() || parts.back() == "..") continue;
    here.file = here.file.lexically_normal();
    return here;
  }
  return {};
}

/// Those below the scan's folder, then those beside it ("source/scan.fbx", "textures/skin.png").
std::vector<fs::path> ScanFiles::usual_folders() {
  const fs::path home = scan_.file.parent_path();
  std::vector<fs::path> folders;
  for (const fs::path& parent : {home, home.parent_path()})
    for (const Entry& entry : entries(parent)) {
      const bool is_home = parent / entry.name == home;
      if (entry.is_folder && !is_home && !entry.readings.empty() &&
          is_usual_folder(entry.readings[0], scan_.file.stem().string()))
        folders.push_back(parent / entry.name);
    }
  return folders;
}

ScanFiles::Found ScanFiles::find_in_usual_folders(const std::string& name) {
  Found first;
  for (const fs::path& folder : usual_folders()) {
    const Found found = find_in(folder, name, false);
    if (found.file.empty()) continue;
    if (first.file.empty()) {
      first = found;
    } else if (folder.parent_path() == first.file.parent_path().parent_path()) {
      first.also_fit.push_back(found.file);
    }
  }
  return first;
}

ScanFiles::Found ScanFiles::find(const fs::path& referrer, const std::vector<std::string>& names) {
  Found found = find_first(referrer, names);
  const auto is_copy = [&found](const fs::path& other) { return read_file(other) == read_file(found.file); };
  found.also_fit.erase(std::remove_if(found.also_fit.begin(), found.also_fit.end(), is_copy),
                       found.also_fit.end());
  return found;
}

ScanFiles::Found ScanFiles::find_first(const fs::path& referrer, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const std::string portable = first_udim_tile(referrer.parent_path(), with_slashes(name));
    const fs::path exact = (referrer.parent_path() / portable).lexically_normal();
    if (!name.empty() && is_file(exact)) return {exact, {}, true};
  }
  std::vector<std::vector<std::string>> paths;
  for (const std::string& name : names) {
    // "skin.png # the skin": a comment where the name as it stands is no file.
    const std::string whole = with_slashes(cleaned(name));
    for (const std::string& variant :
         {whole, cleaned(whole.substr(0, whole.find(" #"))), with_slashes(without_percent_escapes(whole))}) {
      const std::vector<std::string> parts = parts_of(variant);
      if (!parts.empty() && std::find(paths.begin(), paths.end(), parts) == paths.end())
        paths.push_back(parts);
    }
  }
  for (const auto& parts : paths)
    for (const fs::path& folder : {referrer.parent_path(), scan_.file.parent_path()}) {
      const Found found = find_by_path(folder, parts);
      if (!found.file.empty()) return found;
    }
  for (const auto& parts : paths) {
    const Found found = find_in_usual_folders(parts.back());
    if (!found.file.empty()) return found;
  }
  return {};
}

void ScanFiles::note_found(const fs::path& referrer, const std::string& place, const std::string& name,
                           const Found& found) {
  scan_.notes.push_back(readable_name(referrer.filename().string()) + ": " + place + ": '" +
                        readable_name(name) + "' is not there under that name; " + shown_name(found.file) +
                        " is taken for it");
}

std::string ScanFiles::shown_name(const fs::path& file) const {
  return readable_name(file.lexically_relative(scan_.file.parent_path()).string());
}

void ScanFiles::add_missing(const fs::path& referrer, const std::string& place, const std::string& cause,
                            const std::string& mend) {
  scan_.missing.push_back({readable_name(referrer.string()) + ": " + place + ": " + cause, mend});
}

std::string ScanFiles::nearest_name(const fs::path& referrer, const std::string& name,
                                    const std::vector<std::string>& extensions) {
  const std::vector<std::string> wanted = name_readings(name);
  std::string nearest;
  size_t least = std::numeric_limits<size_t>::max();
  for (const Entry& entry : entries(referrer.parent_path())) {
    if (entry.is_folder || entry.readings.empty() || wanted.empty()) continue;
    if (!ends_in(entry.readings[0], extensions)) continue;
    const size_t distance = name_distance(entry.readings[0], wanted[0]);
    if (distance >= least) continue;
    least = distance;
    nearest = entry.name;
  }
  return nearest;
}

ScanPicture ScanFiles::picture(const fs::path& referrer, const std::string& place,
                               const std::vector<std::string>& names) {
  const auto [at, is_new] = found_.try_emplace({referrer.parent_path(), names});
  Found& found = at->second;
  if (is_new) found = find(referrer, names);
  const std::string name = readable_name(names.empty() ? "" : names[0]);
  if (found.file.empty()) {
    const std::vector<std::string> parts = parts_of(with_slashes(cleaned(name)));
    const std::string bare = first_udim_tile(scan_.file.parent_path(), parts.empty() ? "" : parts.back());
    const std::string nearest = nearest_name(scan_.file, bare, kPictureExtensions);
    add_missing(referrer, place, "picture '" + name + "' is not there",
                "put it at " + readable_name((scan_.file.parent_path() / bare).string()) +
                    (referrer == scan_.file ? "" : " or remove the line") +
                    (nearest.empty() ? "" : "; the nearest name there is '" + readable_name(nearest) + "'"));
    return {};
  }
  if (!found.also_fit.empty()) {
    add_missing(referrer, place,
                "picture '" + name + "' is not there, and both " + shown_name(found.file) + " and " +
                    shown_name(found.also_fit[0]) + " may stand for it",
                "remove the wrong one");
    return {};
  }
  if (is_new && !found.is_as_written) note_found(referrer, place, names[0], found);
  try {
    probe_image(found.file);
  } catch (const InputError& error) {
    scan_.missing.push_back({error.what(), ""});
    return {};
  }
  return {found.file, nullptr};
}

std::optional<fs::path> ScanFiles::file(const fs::path& referrer, const std::string& place,
                                        const std::string& name) {
  const Found found = find(referrer, {name});
  if (found.file.empty() || !found.also_fit.empty()) return std::nullopt;
  if (!found.is_as_written) note_found(referrer, place, name, found);
  return found.file;
}

}  // namespace ohb
