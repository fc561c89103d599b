// What a bake did and how well the maps cover the mesh.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <string>
#include <vector>

#include "bake/seams.h"

namespace ohb::bake {

/// How far a map's two sides differ at the seams, as seams.h measures it.
struct MapSeams {
  std::string map, unit;  // "1/255" of sRGB or of the stored value, or "degrees"
  std::vector<SeamError> levels;
  /// The same of the mip levels that are shipped with the map, from level 1 on; empty without.
  std::vector<SeamError> shipped_levels;
  double most_changed = 0;  // of a texel inside a triangle, to make them agree
};

/// One texture set. Areas are of the mesh, in square centimetres.
struct SetReport {
  std::string name, folder;
  int width_px = 0, height_px = 0;
  uint64_t triangles = 0;
  uint64_t centre_texels = 0;                 // whose centre lies in a triangle
  uint64_t footprint_texels = 0;              // read by bilinear lookups at the charts' borders
  uint64_t padded_texels = 0;                 // background, filled so that mips are safe
  uint64_t overlapping_texels = 0;            // whose centre lies in more than one triangle
  uint64_t hidden_triangles = 0;              // with an area, but other triangles lie over all of it in UV
  uint64_t triangles_without_texel = 0;       // with an area, but smaller than a texel amid others
  std::vector<uint32_t> faces_without_texel;  // their source faces, the first kListedFaces
  uint64_t triangles_without_uv_area = 0;
  uint64_t uvs_outside = 0;  // corners beyond [0,1]: the map repeats
  double area_cm2 = 0, mirrored_area_cm2 = 0, area_without_texel_cm2 = 0;
  std::string diffuse, alpha, normal;  // file names of the pictures, "" without
  std::string normal_green;            // "up", "down" (turned over) or "unclear" (read as up); "" without
  uint64_t zero_length_normals = 0;
  std::string
      mask_size;  // "1024 x 1024 of 2048 x 2048": of alpha and diffuse where they differ; "" otherwise
  uint64_t seam_edges = 0;
  uint64_t seam_edges_left_out = 0;  // of triangles that triangles_with_seams leaves out
  std::vector<MapSeams> seams;
  // From a source: what the texels that show a face found, and how far away along their normals.
  uint64_t hit_texels = 0, nearest_texels = 0, missed_texels = 0, back_face_texels = 0;
  uint64_t inward_normal_texels = 0;                 // whose normal points into the scan
  double mean_distance_cm = 0, max_distance_cm = 0;  // of the absolute distances
};

struct BakeReport {
  static constexpr size_t kListedFaces = 100;
  std::string scan, scan_sha256;
  double unit_cm = 1;
  std::string unit_reason;  // given, or why it was taken
  double shift_cm[3] = {0, 0, 0};
  double size_cm[3] = {0, 0, 0};  // bounding box
  uint64_t triangles = 0, positions = 0;
  uint64_t repeated_faces = 0;        // of the scan: exact copies, left out
  std::string source, source_sha256;  // "" without a source
  uint64_t source_triangles = 0;
  double source_unit_cm = 0, outward_cm = 0, inward_cm = 0;  // outward: 0 with a cage
  std::vector<SetReport> sets;
};

/// Limits above which the maps are likely not what the user wants.
constexpr double kMaxOverlapShare = 0.001;        // of the texels whose centre is covered
constexpr double kMaxMissedShare = 0.001;         // of the texels that show a face: the default, fails
constexpr double kMaxSourceOverlapShare = 0.001;  // of the covered texels, with a source: the default, fails
constexpr double kReachShare = 0.01;              // of the low mesh's diagonal: the default reach
constexpr double kMaxInwardNormalShare = 0.001;   // of the texels that found a source
constexpr double kMaxTexelLessAreaShare = 0.001;  // of a set's area

/// One line each for what exceeds a limit, with the mend. Empty if all is well.
std::vector<std::string> warnings_of(const BakeReport& report);

/// For report.json and --json.
nlohmann::ordered_json to_json(const BakeReport& report);

/// For people: one line a set and the warnings.
std::string to_text(const BakeReport& report);

}  // namespace ohb::bake
