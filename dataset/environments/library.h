// An environment library: LIB/envmaps.xml lists LIB/envmaps/<id>.exr, each with hash, licence and light;
// LIB/thumbnails/<id>.png and LIB/sheet.png are for eyes only.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "dataset/environments/sphere_map.h"
#include "dataset/model/image.h"
#include "dataset/model/vec.h"

namespace ohb::environments {

/// What happened to a picture on its way into the library, in texels.
struct MendedTexels {
  size_t nan = 0, infinite = 0, negative = 0;
};

struct LibraryEntry {
  std::string id;        // a-z, 0-9, '_' and '-'; the file is envmaps/<id>.exr
  std::string category;  // "imported", or that of a synthetic one ("sunset", "studio", ...)
  std::string licence, source;
  std::string origin;     // name of the picture it was imported from, or the recipe in words
  std::string made_from;  // everything that decides about the bytes, in words
  std::string sha256;     // of envmaps/<id>.exr
  uint64_t bytes = 0;
  int width_px = 0;
  std::string values = "half";  // or "float", where half cannot hold the light
  LightStatistics light;        // of the file as it is read back
  MendedTexels mended;
};

/// Where the entry's map lies.
std::filesystem::path map_file(const std::filesystem::path& library, const LibraryEntry& entry);

/// The entries of LIB/envmaps.xml, sorted by id; the maps themselves are not looked at. Throws InputError: no
/// library there, envmaps.xml damaged or of a newer version, an id that leaves the folder or occurs twice.
std::vector<LibraryEntry> read_library(const std::filesystem::path& library);

/// What is wrong with the entry's file ("is missing", "was changed ..."), or "".
std::string damage_of(const std::filesystem::path& library, const LibraryEntry& entry);

/// The name as an id: letters without case, anything but a-z, 0-9, '-' as '_', at most 64.
std::string id_of_name(const std::string& name);

/// A library that this process alone writes to: locked until the object, or the process, dies.
class LibraryWriter {
 public:
  /// Makes the folder or goes on with one that is there. Throws InputError: a folder of another kind, or
  /// whose envmaps.xml is damaged; TryAgainError: another process writes to it, disk full.
  explicit LibraryWriter(const std::filesystem::path& library);
  ~LibraryWriter();
  LibraryWriter(const LibraryWriter&) = delete;
  LibraryWriter& operator=(const LibraryWriter&) = delete;

  const std::vector<LibraryEntry>& entries() const { return entries_; }
  const LibraryEntry* find(const std::string& id) const;
  /// The entry made from the same, whose file is whole; null: it is to be made (again).
  const LibraryEntry* find_made_from(const std::string& made_from) const;

  /// Writes the map (2:1, 3 channels, finite, at least 0), its thumbnail and envmaps.xml; replaces an entry
  /// of that id. Fills in sha256, bytes, width_px, values and light. Half values, unless they would change
  /// the light of a channel by more than kHalfTolerance, or are beyond their range: then float.
  /// Throws InputError: a file is in its place that this program did not write; TryAgainError: disk full.
  LibraryEntry add(LibraryEntry entry, const Image& radiance);
  /// Replaces what an entry says of licence and source, if it says otherwise.
  void state_rights(const std::string& id, const std::string& licence, const std::string& source);
  /// All thumbnails in one picture, in the order of envmaps.xml.
  void write_sheet() const;

 private:
  void put(LibraryEntry entry);
  void write_list() const;

  std::filesystem::path library_;
  std::vector<LibraryEntry> entries_;  // sorted by id
  int lock_ = -1;
};

/// Largest relative change of a channel's energy that halves may bring.
constexpr double kHalfTolerance = 2e-4;

}  // namespace ohb::environments
