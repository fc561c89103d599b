#include "dataset/model/scan.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <unordered_map>

#include "dataset/model/error.h"
#include "dataset/model/foreign_content.h"
#include "dataset/model/scan_readers.h"

namespace ohb {
namespace fs = std::filesystem;
namespace {

std::string lower_extension(const fs::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

void check_file(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status)) throw InputError(file.string(), "", "no such file", "check the path");
  if (fs::is_directory(status))
    throw InputError(file.string(), "", "is a folder, not a scan", "name the .obj, .glb or .fbx in it");
  if (!fs::is_regular_file(status))
    throw InputError(file.string(), "", "is no regular file", "copy the scan to a file");
  if (fs::file_size(file, error) == 0)
    throw InputError(file.string(), "", "is empty (0 bytes)", "copy or export it again");
  char start[512] = {};
  std::ifstream stream(file, std::ios::binary);
  stream.read(start, sizeof start);
  refuse_foreign_content(file, std::string_view(start, static_cast<size_t>(stream.gcount())));
}

void check_names(const Scan& scan) {
  for (const auto& [count, what] :
       {std::pair(scan.materials.size(), "materials"), {scan.groups.size(), "groups"}})
    if (count == 0 || count > kMaxScanNames)
      throw InputError(scan.file.string(), "", std::to_string(count) + " " + what,
                       "a scan has 1 to " + std::to_string(kMaxScanNames));
}

void check_numbers(const Scan& scan) {
  for (const ScanMaterial& material : scan.materials)
    if (!(material.opacity >= 0 && material.opacity <= 1) || !is_finite(material.diffuse_factor))
      throw InputError(scan.file.string(), "material '" + material.name + "'",
                       "has an opacity or a colour that is none", "correct the material");
  for (size_t c = 0; c < scan.corner_colours.size(); ++c)
    if (!is_finite(scan.corner_colours[c].rgb) ||
        !(scan.corner_colours[c].alpha >= 0 && scan.corner_colours[c].alpha <= 1))
      throw InputError(scan.file.string(), numbered("corner", c), "has a colour that is none",
                       "remove the colours at the vertices or correct them");
  for (size_t i = 0; i < scan.positions.size(); ++i)
    if (!is_finite(scan.positions[i]))
      throw InputError(scan.file.string(), numbered("vertex", i), "is not finite",
                       "remove the vertex and its faces");
  for (size_t i = 0; i < scan.uvs.size(); ++i)
    if (!is_finite(scan.uvs[i]))
      throw InputError(scan.file.string(), numbered("UV", i), "is not finite", "unwrap its faces again");
}

void check_faces(const Scan& scan) {
  if (scan.face_count() == 0)
    throw InputError(scan.file.string(), "", "has no faces", "export the surface, not points or lines");
  for (size_t f = 0; f < scan.face_count(); ++f) {
    const size_t first = scan.face_begin[f], end = scan.face_begin[f + 1];
    if (end < first + 3 || end - first > kMaxFaceCorners)
      throw InputError(scan.file.string(), numbered("face", f),
                       "has " + std::to_string(end - first) + " corners",
                       "a face has 3 to " + std::to_string(kMaxFaceCorners));
    for (size_t c = first; c < end; ++c) {
      const Corner& corner = scan.corners[c];
      if (corner.position >= scan.positions.size() ||
          (corner.uv != Corner::kNoUv && corner.uv >= scan.uvs.size()))
        throw InputError(scan.file.string(), numbered("face", f), "has an index out of range",
                         "export the scan again");
    }
  }
}

void check_missing(const Scan& scan) {
  if (scan.missing.empty()) return;
  const size_t others = scan.missing.size() - 1;
  throw InputError(
      "", "", scan.missing[0].what,
      scan.missing[0].mend +
          (others == 0 ? "" : "; so with " + std::to_string(others) + " more, which inspect lists"));
}

}  // namespace

std::string numbered(const char* what, size_t index) {
  return std::string(what) + " " + std::to_string(index + 1);
}

Scan read_scan(const fs::path& file, MissingFiles missing) {
  check_file(file);
  const fs::path absolute = fs::absolute(file).lexically_normal();
  const std::string extension = lower_extension(file);
  Scan scan;
  if (extension == ".obj") {
    scan = read_obj(absolute);
  } else if (extension == ".glb" || extension == ".gltf") {
    scan = read_gltf(absolute);
  } else if (extension == ".fbx") {
    scan = read_fbx(absolute);
  } else {
    throw InputError(file.string(), "", "unknown format '" + extension + "'",
                     "export the scan as .obj, .glb or .fbx");
  }
  check_faces(scan);
  check_names(scan);
  check_numbers(scan);
  split_udim_tiles(scan);
  settle_pictures(scan);
  settle_opacity(scan);
  if (missing == MissingFiles::kRefused) check_missing(scan);
  return scan;
}

ScanPicture embed_picture(const fs::path& scan_file, const std::string& name, std::string bytes) {
  ScanPicture picture;
  picture.file = scan_file.string() + "#" + name;
  probe_image_bytes(bytes, picture.file.string());
  picture.embedded = std::make_shared<const std::string>(std::move(bytes));
  return picture;
}

bool is_normal_map(const ScanPicture& picture) {
  const Image image = read_image(picture);
  if (image.channels < 3) return false;
  const size_t pixels = static_cast<size_t>(image.width_px) * image.height_px;
  const size_t step = pixels / 65536 + 1;
  size_t grey = 0, seen = 0;
  for (size_t i = 0; i < pixels; i += step, ++seen) {
    const float* p = &image.values[i * image.channels];
    if (std::abs(p[0] - p[2]) < 0.02f && std::abs(p[1] - p[2]) < 0.02f) ++grey;
  }
  return grey * 2 < seen;
}

void begin_face(Scan& scan, size_t material, size_t group) {
  scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
  scan.face_material.push_back(static_cast<uint16_t>(material));
  scan.face_group.push_back(static_cast<uint16_t>(group));
}

void close_faces(Scan& scan) {
  scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
}

namespace {

struct PositionBits {
  uint32_t x, y, z;
  bool operator==(const PositionBits& o) const { return x == o.x && y == o.y && z == o.z; }
};

PositionBits bits_of(Vec3f p) {
  const float xyz[3] = {p.x + 0.0f, p.y + 0.0f, p.z + 0.0f};  // -0 + 0 is +0
  PositionBits bits;
  std::memcpy(&bits, xyz, sizeof bits);
  return bits;
}

struct PositionHash {
  size_t operator()(const PositionBits& b) const {
    uint64_t h = b.x * 0x9E3779B97F4A7C15ull;
    h = (h ^ (h >> 29) ^ b.y) * 0xBF58476D1CE4E5B9ull;
    h = (h ^ (h >> 32) ^ b.z) * 0x94D049BB133111EBull;
    return h ^ (h >> 31);
  }
};

}  // namespace

void weld_positions(Scan& scan, size_t first, size_t first_corner) {
  std::unordered_map<PositionBits, uint32_t, PositionHash> kept;
  std::vector<uint32_t> target(scan.positions.size() - first);
  size_t next = first;
  for (size_t i = first; i < scan.positions.size(); ++i) {
    const auto [found, is_new] = kept.emplace(bits_of(scan.positions[i]), static_cast<uint32_t>(next));
    if (is_new) scan.positions[next++] = scan.positions[i];
    target[i - first] = found->second;
  }
  scan.positions.resize(next);
  for (size_t c = first_corner; c < scan.corners.size(); ++c)
    scan.corners[c].position = target[scan.corners[c].position - first];
}

}  // namespace ohb
