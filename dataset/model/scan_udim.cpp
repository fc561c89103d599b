// Pictures that are tiled over UV space (UDIM): tile 1001 + column + 10 row covers [column, column + 1) x
// [row, row + 1).
#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <unordered_map>

#include "dataset/model/error.h"
#include "dataset/model/scan_readers.h"

namespace ohb {
namespace fs = std::filesystem;
namespace {

constexpr int kFirstTile = 1001, kLastTile = 1999, kTileDigits = 4;
constexpr const char* kPlaceholder = "<UDIM>";

/// Where a file's name holds the number of a tile: its last four digits alone that are one.
std::optional<size_t> tile_place(const std::string& name) {
  const auto is_digit = [&](size_t i) {
    return i < name.size() && std::isdigit(static_cast<unsigned char>(name[i]));
  };
  for (size_t i = name.size() < kTileDigits ? 0 : name.size() - kTileDigits + 1; i-- > 0;) {
    if (is_digit(i + kTileDigits) || (i > 0 && is_digit(i - 1))) continue;
    bool all = true;
    for (size_t k = 0; k < kTileDigits; ++k) all = all && is_digit(i + k);
    if (!all) continue;
    const int tile = std::stoi(name.substr(i, kTileDigits));
    if (tile >= kFirstTile && tile <= kLastTile) return i;
  }
  return std::nullopt;
}

/// The file of another tile; empty if the picture's name holds no tile.
fs::path file_of_tile(const ScanPicture& picture, int tile) {
  if (picture.empty() || picture.embedded) return {};
  std::string name = picture.file.filename().string();
  const std::optional<size_t> place = tile_place(name);
  if (!place) return {};
  name.replace(*place, kTileDigits, std::to_string(tile));
  return picture.file.parent_path() / name;
}

/// The tile that the face's middle lies in: a corner at u = 1 exactly belongs to the tile on either side. 0:
/// outside all tiles.
int tile_of_face(const Scan& scan, size_t face) {
  double u = 0, v = 0;
  const size_t first = scan.face_begin[face], end = scan.face_begin[face + 1];
  for (size_t c = first; c < end; ++c) {
    if (scan.corners[c].uv == Corner::kNoUv) return kFirstTile;
    u += scan.uvs[scan.corners[c].uv].x;
    v += scan.uvs[scan.corners[c].uv].y;
  }
  const double count = static_cast<double>(end - first);
  const double column = std::floor(u / count), row = std::floor(v / count);
  if (!(column >= 0 && column < 10 && row >= 0 && row < 99)) return 0;
  return kFirstTile + static_cast<int>(column) + 10 * static_cast<int>(row);
}

/// Whether a picture of the material is of one of the tiles in which its faces lie, or of the first, and
/// there is a file of another tile beside it: "img_1050.jpg" beside "img_1051.jpg" is no tile while no face
/// is there.
bool has_tiles(const ScanMaterial& material, const std::set<int>& tiles) {
  if (tiles.empty() || tiles == std::set<int>{kFirstTile}) return false;
  std::error_code error;
  for (const ScanPicture* picture : {&material.diffuse, &material.alpha, &material.normal}) {
    if (picture->empty() || picture->embedded) continue;
    const auto is_own = [&](int tile) { return file_of_tile(*picture, tile) == picture->file; };
    if (!is_own(kFirstTile) && std::none_of(tiles.begin(), tiles.end(), is_own)) continue;
    for (int tile = kFirstTile; tile <= kLastTile; ++tile)
      if (!is_own(tile) && fs::is_regular_file(file_of_tile(*picture, tile), error)) return true;
  }
  return false;
}

ScanMaterial material_of_tile(Scan& scan, const ScanMaterial& from, int tile, size_t face) {
  ScanMaterial material = from;
  material.name += "." + std::to_string(tile);
  std::error_code error;
  for (ScanPicture* picture : {&material.diffuse, &material.alpha, &material.normal}) {
    const fs::path file = file_of_tile(*picture, tile);
    if (file.empty()) continue;
    *picture = {};
    if (fs::is_regular_file(file, error)) {
      probe_image(file);
      *picture = {file, nullptr};
    } else {
      scan.missing.push_back({scan.file.string() + ": " + numbered("face", face) + ": is of UDIM tile " +
                                  std::to_string(tile) + ", whose picture is not there",
                              "put it at " + file.string() + " or move the face's UVs"});
    }
  }
  return material;
}

/// Moves the UVs of a face into [0,1]; UVs that other tiles use too are copied.
class UvMover {
 public:
  explicit UvMover(Scan& scan) : scan_(scan) {}
  void move(size_t face, int tile) {
    if (tile == kFirstTile) return;
    const Vec2f origin{static_cast<float>((tile - kFirstTile) % 10),
                       static_cast<float>((tile - kFirstTile) / 10)};
    for (size_t c = scan_.face_begin[face]; c < scan_.face_begin[face + 1]; ++c) {
      uint32_t& uv = scan_.corners[c].uv;
      const uint64_t key = uint64_t{uv} << 16 | static_cast<uint64_t>(tile);
      const auto [at, is_new] = moved_.emplace(key, static_cast<uint32_t>(scan_.uvs.size()));
      if (is_new) scan_.uvs.push_back(scan_.uvs[uv] - origin);
      uv = at->second;
    }
  }

 private:
  Scan& scan_;
  std::unordered_map<uint64_t, uint32_t> moved_;
};

}  // namespace

std::string first_udim_tile(const fs::path& folder, const std::string& name) {
  const size_t place = name.find(kPlaceholder);
  if (place == std::string::npos) return name;
  const auto with = [&](int tile) {
    std::string file = name;
    return file.replace(place, std::string(kPlaceholder).size(), std::to_string(tile));
  };
  std::error_code error;
  for (int tile = kFirstTile; tile <= kLastTile; ++tile)
    if (fs::is_regular_file(folder / with(tile), error)) return with(tile);
  return with(kFirstTile);
}

std::string with_udim_tile_of(const std::string& name, const std::string& other) {
  const size_t place = name.find(kPlaceholder);
  const std::optional<size_t> tile = place == std::string::npos ? std::nullopt : tile_place(other);
  if (!tile) return name;
  return std::string(name).replace(place, std::string(kPlaceholder).size(), other.substr(*tile, kTileDigits));
}

void split_udim_tiles(Scan& scan) {
  std::vector<std::set<int>> tiles(scan.materials.size());
  for (size_t f = 0; f < scan.face_count(); ++f) tiles[scan.face_material[f]].insert(tile_of_face(scan, f));
  std::vector<bool> is_tiled;
  for (size_t m = 0; m < tiles.size(); ++m) is_tiled.push_back(has_tiles(scan.materials[m], tiles[m]));
  std::map<std::pair<uint16_t, int>, uint16_t> material_of;  // by material and tile
  const std::vector<ScanMaterial> untiled = scan.materials;
  UvMover mover(scan);
  std::vector<bool> is_used(untiled.size(), false);
  for (size_t f = 0; f < scan.face_count(); ++f) {
    const uint16_t material = scan.face_material[f];
    if (!is_tiled[material]) continue;
    const int tile = tile_of_face(scan, f);
    if (tile == 0)
      throw InputError(scan.file.string(), numbered("face", f), "lies outside the UDIM tiles of its picture",
                       "move its UVs into columns 0 to 9 and rows from 0 on");
    const auto known = material_of.find({material, tile});
    if (known != material_of.end()) {
      scan.face_material[f] = known->second;
    } else {
      ScanMaterial here = material_of_tile(scan, untiled[material], tile, f);
      uint16_t number = material;  // the first tile takes the material's place
      if (is_used[material]) {
        if (scan.materials.size() >= kMaxScanNames)
          throw InputError(scan.file.string(), numbered("face", f), "is of one UDIM tile too many",
                           "a scan has 1 to " + std::to_string(kMaxScanNames) + " materials and tiles");
        number = static_cast<uint16_t>(scan.materials.size());
        scan.materials.emplace_back();
      }
      is_used[material] = true;
      scan.materials[number] = std::move(here);
      scan.face_material[f] = material_of[{material, tile}] = number;
    }
    mover.move(f, tile);
  }
}

}  // namespace ohb
