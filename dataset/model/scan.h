// A scan as its file holds it: polygons in source order, one index for position and one for UV a corner.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dataset/model/affine.h"
#include "dataset/model/image.h"
#include "dataset/model/vec.h"

namespace ohb {

/// What a picture shows beyond its borders, along one axis.
enum class Wrap : uint8_t { kRepeat, kMirror, kClamp };

/// How a UV (v up) finds its place in a picture: (uu u + uv v + u0, vu u + vv v + v0), then wrapped. Readers
/// state what their file says; read_scan() moves UVs so that as many views as can be are plain.
struct PictureView {
  double uu = 1, uv = 0, u0 = 0;
  double vu = 0, vv = 1, v0 = 0;
  Wrap wrap_u = Wrap::kRepeat, wrap_v = Wrap::kRepeat;
  /// Whether UVs are places in the picture as they are, repeated.
  bool is_plain() const;
};

/// A picture of a material: a file on disk, or the bytes of one that the scan's own file embeds (GLB, FBX).
/// Embedded pictures stay in memory: reading a scan writes nothing.
struct ScanPicture {
  std::filesystem::path file;  // absolute; embedded: "<scan file>#<name>", a unique key, no file
  std::shared_ptr<const std::string> embedded;  // the encoded PNG, JPEG, ... ; null for a file on disk
  PictureView view = {};
  bool empty() const { return file.empty(); }
};

/// Longest edge of what read_image() makes of a picture whose view is not plain.
constexpr int kMaxViewedEdge_px = 8192;

/// What UVs from 0 to 1 show of the picture, which repeats beyond; of a plain view its pixels as
/// read_image(path) gives them: values as stored, alpha not premultiplied. Other views are looked up
/// bilinearly (in the values as stored, as Cycles does), with at least as many pixels as the picture has
/// there; where pixels meet pixels they are copied. Throws InputError naming `picture.file` if it is
/// truncated or not an image.
Image read_image(const ScanPicture& picture, ImageFileInfo* info = nullptr);
/// What read_image would say in `info`.
ImageFileInfo probe_image(const ScanPicture& picture);

/// One material of the file. Pictures exist and carry the header of an image; empty() if there is none.
/// Colour = picture x diffuse_factor x colour at the vertices. Opacity = picture x opacity x alpha at the
/// vertices; with a cutoff 1 where that reaches it, else 0.
struct ScanMaterial {
  std::string name;
  ScanPicture diffuse;            // sRGB colour; its alpha channel is not used unless `alpha` names it too
  ScanPicture alpha;              // cut-out: the alpha channel if the picture has one, else its red
  ScanPicture normal;             // tangent space
  Vec3f diffuse_factor{1, 1, 1};  // linear; multiplies the picture, or is the colour where there is none
  float opacity = 1;              // in [0,1]
  std::optional<float> alpha_cutoff;  // glTF's MASK
  // Set by read_scan(): whether a corner of its faces has a colour or an alpha other than 1.
  bool has_vertex_colours = false, has_vertex_alpha = false;

  bool is_opaque() const { return alpha.empty() && opacity >= 1 && !has_vertex_alpha; }
  /// The opacity that a value of the picture (times the vertices' alpha) makes.
  float opacity_of(float value) const {
    const float product = value * opacity;
    return alpha_cutoff ? (product >= *alpha_cutoff ? 1.0f : 0.0f) : product;
  }
};

/// Linear Rec. 709 and opacity, at a corner of a face.
struct VertexColour {
  Vec3f rgb{1, 1, 1};
  float alpha = 1;
};

struct Corner {
  static constexpr uint32_t kNoUv = 0xffffffffu;
  uint32_t position = 0;
  uint32_t uv = kNoUv;
};

/// A file that the scan names and that is not there or cannot be used.
struct MissingFile {
  std::string what;  // "<file>: <place>: <cause>"
  std::string mend;  // may be empty
};

/// Positions are in the file's own unit and axes until `to_canonical`. Faces keep the order of the file
/// and corners their order in the face: labels index them.
struct Scan {
  std::filesystem::path file;
  std::vector<Vec3f> positions;
  std::vector<Vec2f> uvs;            // v up
  std::vector<uint32_t> face_begin;  // face f has corners [face_begin[f], face_begin[f + 1])
  std::vector<Corner> corners;
  std::vector<VertexColour> corner_colours;  // one a corner; empty if no face has any
  std::vector<uint16_t> face_material;       // index into materials
  std::vector<uint16_t> face_group;          // index into groups
  std::vector<ScanMaterial> materials;
  std::vector<std::string> groups;       // object or group names; at least one
  std::optional<double> stated_unit_cm;  // cm a unit, where the format states it (glTF: 100, FBX)
  /// Taken off all positions where they lay so far away that single precision lost their detail (maps'
  /// coordinates): position in the file = position + removed_offset.
  std::optional<Vec3d> removed_offset;
  std::vector<std::string> notes;    // what the file holds and is not used or was changed, one line each
  std::vector<MissingFile> missing;  // what the file names; the materials lack these pictures
  bool has_file_normals = false;     // read and not used: normals are smooth over shared positions

  size_t face_count() const { return face_begin.empty() ? 0 : face_begin.size() - 1; }
};

/// What becomes of pictures and .mtl files that are not there: an InputError, or lines in Scan::missing.
enum class MissingFiles { kRefused, kReported };

/// Reads .obj (with its .mtl), .glb/.gltf or .fbx (7, binary or ASCII). glTF vertices that were split at UV
/// seams are welded within their object where positions are bitwise equal, so that smooth normals do not
/// crack. Node transforms are applied; rigs take the pose of the nodes in glTF and stay at rest in FBX; FBX
/// is turned to its stated up axis = +Y. Throws InputError: no such file, unknown format, truncated or
/// malformed, no faces, index out of range, NaN or infinite position or UV (naming the vertex), missing or
/// unreadable picture or .mtl if `missing` says so.
Scan read_scan(const std::filesystem::path& file, MissingFiles missing = MissingFiles::kRefused);

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
