// A scan as its file holds it: polygons in source order, one index for position and one for UV a corner.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dataset/model/image.h"
#include "dataset/model/vec.h"

namespace ohb {

/// A picture of a material: a file on disk, or the bytes of one that the scan's own file embeds (GLB, FBX).
/// Embedded pictures stay in memory: reading a scan writes nothing.
struct ScanPicture {
  std::filesystem::path file;  // absolute; embedded: "<scan file>#<name>", a unique key, no file
  std::shared_ptr<const std::string> embedded;  // the encoded PNG, JPEG, ... ; null for a file on disk
  bool empty() const { return file.empty(); }
};

/// The picture's pixels as read_image(path) gives them: values as stored, alpha not premultiplied.
/// Throws InputError naming `picture.file` if it is truncated or not an image.
Image read_image(const ScanPicture& picture, ImageFileInfo* info = nullptr);
/// Its header only.
ImageFileInfo probe_image(const ScanPicture& picture);

/// One material of the file. Pictures exist and carry the header of an image; empty() if there is none.
struct ScanMaterial {
  std::string name;
  ScanPicture diffuse;            // sRGB colour; its alpha channel is not used unless `alpha` names it too
  ScanPicture alpha;              // cut-out: the alpha channel if the picture has one, else its red
  ScanPicture normal;             // tangent space
  Vec3f diffuse_factor{1, 1, 1};  // linear; multiplies the picture, or is the colour where there is none
};

struct Corner {
  static constexpr uint32_t kNoUv = 0xffffffffu;
  uint32_t position = 0;
  uint32_t uv = kNoUv;
};

/// Positions are in the file's own unit and axes until `to_canonical`. Faces keep the order of the file
/// and corners their order in the face: labels index them.
struct Scan {
  std::filesystem::path file;
  std::vector<Vec3f> positions;
  std::vector<Vec2f> uvs;            // v up
  std::vector<uint32_t> face_begin;  // face f has corners [face_begin[f], face_begin[f + 1])
  std::vector<Corner> corners;
  std::vector<uint16_t> face_material;  // index into materials
  std::vector<uint16_t> face_group;     // index into groups
  std::vector<ScanMaterial> materials;
  std::vector<std::string> groups;       // object or group names; at least one
  std::optional<double> stated_unit_cm;  // cm a unit, where the format states it (glTF: 100, FBX)
  std::vector<std::string> notes;        // what the file holds and is not used, one line each
  bool has_file_normals = false;         // read and not used: normals are smooth over shared positions

  size_t face_count() const { return face_begin.empty() ? 0 : face_begin.size() - 1; }
};

/// Reads .obj (with its .mtl), .glb/.gltf or .fbx (7, binary or ASCII). glTF vertices that were split at UV
/// seams are welded within their object where positions are bitwise equal, so that smooth normals do not
/// crack. Node transforms are applied, rigged meshes stay at rest; FBX is turned to its stated up axis = +Y.
/// Throws InputError: no such file, unknown format, truncated or malformed, no faces, index out of range,
/// NaN or infinite position or UV (naming the vertex), missing or unreadable picture.
Scan read_scan(const std::filesystem::path& file);

/// One triangle of a scan: corner indices into Scan::corners, and the face that it comes from.
struct ScanTriangle {
  uint32_t corner[3];
  uint32_t face;
};

/// Triangles in face order. Quads split along the shorter diagonal (the other one where a concave quad would
/// fold over), larger polygons by ear clipping; winding is kept. Zero-area triangles are kept too (labels
/// index faces); `inspect` counts them.
std::vector<ScanTriangle> triangulate(const Scan& scan);

}  // namespace ohb
