#include "dataset/environments/library.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>

#include "dataset/environments/library_list.h"
#include "dataset/environments/thumbnails.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/error.h"
#include "dataset/model/halves.h"
#include "dataset/model/sample.h"

namespace ohb::environments {
namespace fs = std::filesystem;
namespace {

constexpr const char* kKind = "environment library";
constexpr const char* kList = "envmaps.xml";
constexpr const char* kIdAttribute = "ohb:environment";

bool id_is_less(const LibraryEntry& a, const LibraryEntry& b) {
  return a.id < b.id;
}

/// The map as halves hold it.
Image as_halves(const Image& image) {
  Image rounded = image;
  const std::vector<uint16_t> halves = halves_of(image.values.data(), image.values.size());
  floats_of(halves.data(), halves.size(), rounded.values.data());
  return rounded;
}

bool holds_the_light(const Image& halves, const Image& radiance) {
  const std::array<double, 3> before = energy_of(radiance), after = energy_of(halves);
  for (size_t c = 0; c < 3; ++c)
    if (std::fabs(after[c] - before[c]) > kHalfTolerance * before[c]) return false;
  return *std::max_element(radiance.values.begin(), radiance.values.end()) <= kLargestHalf;
}

/// Somebody's own file is not overwritten; ours say so in their header.
void check_is_ours(const fs::path& file, const std::string& id) {
  if (!fs::exists(file)) return;
  try {
    for (const auto& [name, value] : read_sample_attributes(file))
      if (name == kIdAttribute && value == id) return;
  } catch (const InputError&) {
  }
  throw InputError(file.string(), "", "is in the way: it was not written by this program",
                   "move it elsewhere");
}

int locked(const fs::path& library) {
  const fs::path marker = library / ".openhumanbrdf";
  const int handle = ::open(marker.c_str(), O_RDONLY | O_CLOEXEC);
  if (handle >= 0 && ::flock(handle, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    ::close(handle);
    throw TryAgainError(library.string(), "another command is writing to it", "run this one when it is done");
  }
  return handle;
}

}  // namespace

fs::path map_file(const fs::path& library, const LibraryEntry& entry) {
  return library / "envmaps" / (entry.id + ".exr");
}

std::vector<LibraryEntry> read_library(const fs::path& library) {
  if (!fs::is_regular_file(library / kList))
    throw InputError(library.string(), "", "is no environment library: it has no envmaps.xml",
                     "make one with openhumanbrdf environments import, or synthesise");
  return read_library_list(library / kList);
}

std::string damage_of(const fs::path& library, const LibraryEntry& entry) {
  const fs::path file = map_file(library, entry);
  std::error_code error;
  const uintmax_t bytes = fs::file_size(file, error);
  if (error) return "is missing";
  if (bytes != entry.bytes)
    return "was changed: it has " + std::to_string(bytes) + " bytes, not " + std::to_string(entry.bytes);
  return sha256_of_file(file) == entry.sha256 ? "" : "was changed: its hash is another one";
}

std::string id_of_name(const std::string& name) {
  constexpr size_t kLongest = 64;
  std::string id;
  for (const char c : name.substr(0, kLongest)) {
    const char lower = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    const bool is_plain = (lower >= 'a' && lower <= 'z') || (lower >= '0' && lower <= '9') || lower == '-';
    id += is_plain ? lower : '_';
  }
  return id.empty() ? "_" : id;
}

LibraryWriter::LibraryWriter(const fs::path& library) : library_(library) {
  claim_folder(library, kKind);
  lock_ = locked(library);
  try {
    if (fs::exists(library / kList)) entries_ = read_library_list(library / kList);
    make_folders(library / "envmaps");
    make_folders(library / "thumbnails");
  } catch (...) {
    ::close(lock_);
    throw;
  }
}

LibraryWriter::~LibraryWriter() {
  if (entries_.empty()) {  // nothing came of it: what is empty goes
    std::error_code ignored;
    fs::remove(library_ / "envmaps", ignored);
    fs::remove(library_ / "thumbnails", ignored);
    const auto entries = std::distance(fs::directory_iterator(library_, ignored), fs::directory_iterator());
    if (entries == 1 && fs::remove(library_ / ".openhumanbrdf", ignored)) fs::remove(library_, ignored);
  }
  if (lock_ >= 0) ::close(lock_);
}

const LibraryEntry* LibraryWriter::find(const std::string& id) const {
  for (const LibraryEntry& entry : entries_)
    if (entry.id == id) return &entry;
  return nullptr;
}

const LibraryEntry* LibraryWriter::find_made_from(const std::string& made_from) const {
  for (const LibraryEntry& entry : entries_)
    if (entry.made_from == made_from && damage_of(library_, entry).empty() &&
        fs::exists(thumbnail_file(library_, entry.id)))
      return &entry;
  return nullptr;
}

LibraryEntry LibraryWriter::add(LibraryEntry entry, const Image& radiance) {
  const fs::path file = map_file(library_, entry);
  check_is_ours(file, entry.id);
  const Image halves = as_halves(radiance);
  const bool is_half = holds_the_light(halves, radiance);
  entry.values = is_half ? "half" : "float";
  entry.width_px = radiance.width_px;
  entry.light = statistics_of(is_half ? halves : radiance);
  const auto type = is_half ? ExrPart::Type::kHalf : ExrPart::Type::kFloat;
  write_exr(file, {{"", {"R", "G", "B"}, type, radiance}},
            {{kIdAttribute, entry.id},
             {"ohb:licence", entry.licence},
             {"ohb:source", entry.source},
             {"ohb:madeFrom", entry.made_from}});
  entry.bytes = fs::file_size(file);
  entry.sha256 = sha256_of_file(file);
  write_thumbnail(library_, entry.id, radiance);
  put(entry);
  return entry;
}

void LibraryWriter::state_rights(const std::string& id, const std::string& licence,
                                 const std::string& source) {
  const LibraryEntry* entry = find(id);
  if (!entry || (entry->licence == licence && entry->source == source)) return;
  LibraryEntry stated = *entry;
  stated.licence = licence, stated.source = source;
  put(std::move(stated));
}

void LibraryWriter::put(LibraryEntry entry) {
  const auto place = std::lower_bound(entries_.begin(), entries_.end(), entry, id_is_less);
  if (place != entries_.end() && place->id == entry.id)
    *place = std::move(entry);
  else
    entries_.insert(place, std::move(entry));
  write_list();
}

void LibraryWriter::write_list() const {
  write_file_atomically(library_ / kList, library_list_text(entries_));
}

void LibraryWriter::write_sheet() const {
  std::vector<std::string> ids;
  for (const LibraryEntry& entry : entries_) ids.push_back(entry.id);
  write_thumbnail_sheet(library_, ids);
}

}  // namespace ohb::environments
