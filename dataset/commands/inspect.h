// What a scan is and what is wrong with it, before anything is labelled or baked.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "dataset/commands/normal_convention.h"
#include "dataset/commands/uv_layout.h"
#include "dataset/model/scan.h"
#include "dataset/model/scan_unit.h"

namespace ohb::commands {

struct PictureReport {
  std::string use;   // "diffuse", "alpha" or "normal"
  std::string file;  // as ScanPicture::file
  ImageFileInfo info;
  bool is_cut_out = false;            // the alpha picture, or a diffuse one with an alpha channel
  double transparent_share = 0;       // of the covered texels: not opaque, if is_cut_out
  NormalConventionResult convention;  // of normal maps
};

struct MaterialReport {
  std::string name;
  UvLayout uv;
  std::vector<PictureReport> pictures;
  float opacity = 1;                  // multiplies the cut-out, or is all there is
  std::optional<float> alpha_cutoff;  // opaque from here on, else clear
  bool has_vertex_colours = false;
};

/// Something that the user should know, in plain words, and what to do about it.
struct Warning {
  std::string what, mend;
};

struct InspectReport {
  std::string file;
  // Counts.
  size_t vertices = 0, unused_vertices = 0, uvs = 0;
  size_t faces = 0, triangle_faces = 0, quad_faces = 0, larger_faces = 0, triangles = 0;
  std::vector<std::string> groups;
  std::vector<MaterialReport> materials;
  bool has_file_normals = false;
  // Size, in the file's unit; unit as the file, the height or the user says.
  Bounds bounds;
  UnitGuess unit;
  std::string lying;   // lying_reason, where the unit is known
  std::string facing;  // facing_elsewhere, of a person whose unit is known
  // Faces and edges of the mesh welded across UV seams.
  size_t points = 0;           // vertices after welding
  size_t zero_area_faces = 0;  // no area in 3-D, as faces with a repeated vertex have none
  size_t repeated_vertex_faces = 0;
  size_t duplicate_faces = 0;                   // the same points as an earlier face
  size_t border_edges = 0, holes = 0;           // edges of one face, and the connected groups that they form
  size_t non_manifold_edges = 0;                // edges of more than two faces
  size_t inconsistent_edges = 0;                // both faces run along them the same way: one is inside out
  size_t components = 0, small_components = 0;  // joined by edges; small: below 0.1 % of the area
  std::optional<Vec3d> removed_offset;          // as in Scan
  std::vector<std::string> notes;
  std::vector<Warning> missing;  // pictures and .mtl files that the scan names: label and bake refuse it
  std::vector<Warning> warnings;
};

/// Measures everything; `unit_option` as in resolve_unit_cm, but an unknown unit is a warning here, and so is
/// a scan that seems to lie or to face elsewhere, unless `up_is_given` (--up: it is meant).
/// Throws InputError for a wrong unit word and for a picture that cannot be decoded.
InspectReport inspect_scan(const Scan& scan, const std::optional<std::string>& unit_option,
                           bool up_is_given = false);

/// The report as a readable table, lines of at most about 110 characters.
std::string inspect_text(const InspectReport& report);
/// The report as one JSON object; lengths in the file's unit and in cm where the unit is known.
nlohmann::ordered_json inspect_json(const InspectReport& report);

}  // namespace ohb::commands
