#include "dataset/commands/inspect_warnings.h"

#include <cmath>
#include <cstdio>

namespace ohb::commands {
namespace {

/// Shares below these are noise of real layouts and not worth a line.
constexpr double kOverlapShare = 0.001, kFlippedShare = 0.001, kTransparentShare = 0.001;
constexpr double kAllTransparent = 0.999;

std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g %%", 100 * share);
  return text;
}

/// "1 face", "12 faces"
std::string counted(size_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}
std::string faces(size_t count) {
  return counted(count, "face", "faces");
}

class Warnings {
 public:
  void add(bool is_true, const std::string& what, const std::string& mend) {
    if (is_true) list_.push_back({what, mend});
  }
  std::vector<Warning> list_;
};

void warn_about_mesh(const InspectReport& r, Warnings& warnings) {
  warnings.add(
      r.inconsistent_edges > 0,
      counted(r.inconsistent_edges, "edge joins faces", "edges join faces") + " that are wound opposite ways",
      "recalculate the faces' outside in your modelling program: the inside renders dark");
  warnings.add(
      r.non_manifold_edges > 0,
      counted(r.non_manifold_edges, "edge has", "edges have") + " more than two faces (non-manifold)",
      "rendering works; smooth normals there mix all of them: separate the sheets if it shows");
  warnings.add(r.duplicate_faces > 0, faces(r.duplicate_faces) + " repeat another face's vertices",
               "remove the copies: they hide each other and confuse labels; bake leaves exact ones out");
  warnings.add(r.repeated_vertex_faces > 0, faces(r.repeated_vertex_faces) + " use a vertex twice",
               "harmless where they have no area; dissolve degenerate faces to be rid of them");
  warnings.add(r.zero_area_faces > 0, faces(r.zero_area_faces) + " have no area",
               "harmless: they are kept, since labels count faces, and never seen");
  warnings.add(r.unused_vertices > 0,
               counted(r.unused_vertices, "vertex is", "vertices are") + " used by no face",
               "harmless; delete loose vertices to be rid of them");
  warnings.add(r.border_edges > 0,
               "the surface is open: " + counted(r.border_edges, "border edge", "border edges") + " in " +
                   counted(r.holes, "hole or rim", "holes or rims"),
               "usual for scans; close holes that the camera sees into");
  warnings.add(r.small_components > 0,
               counted(r.small_components, "separate piece has", "separate pieces have") +
                   " less than 0.1 % of the area each",
               "delete them if they are scanner noise");
}

void warn_about_uv(const MaterialReport& m, Warnings& warnings) {
  const std::string who = "material '" + m.name + "': ";
  const UvLayout& uv = m.uv;
  warnings.add(uv.faces_without_uv > 0, who + faces(uv.faces_without_uv) + " have no UVs",
               "unwrap them: maps cannot be baked for them");
  warnings.add(uv.face_count > uv.faces_without_uv && !uv.is_measured,
               who + "faces cover the picture too many times to measure", "unwrap them into the unit square");
  warnings.add(uv.faces_outside > 0,
               who + faces(uv.faces_outside) + " lie outside the unit UV square" +
                   (uv.tiles.size() > 1 ? " (" + std::to_string(uv.tiles.size()) + " UDIM tiles)" : ""),
               uv.tiles.size() > 1 ? "pictures repeat there; if the scan has one picture a tile, name them "
                                     "by it (picture.1001.png, ...)"
                                   : "pictures repeat there; move the UVs into the unit square");
  warnings.add(uv.overlap_share > kOverlapShare,
               who + percent(uv.overlap_share) + " of the covered UV area is used by several faces",
               "faces that share texels share their maps; unwrap them apart if they should differ");
  warnings.add(uv.flipped_share > kFlippedShare,
               who + percent(uv.flipped_share) + " of the UV area is mirrored",
               "usual for symmetric layouts; mirrored writing shows where it is not meant");
  warnings.add(uv.zero_area_faces > 0, who + faces(uv.zero_area_faces) + " have no UV area",
               "they get a single texel; unwrap them if they are seen");
}

/// What to do in a scan of the file's format.
struct PictureMends {
  std::string diffuse, cut_out;
};

PictureMends picture_mends(const std::string& file) {
  const bool is_obj =
      file.size() > 4 && (file.substr(file.size() - 4) == ".obj" || file.substr(file.size() - 4) == ".OBJ");
  if (is_obj)
    return {"add map_Kd to the .mtl, or its albedo is one colour",
            "add map_d -imfchan m with the same picture to the .mtl, or remove the alpha channel"};
  return {"give it a base colour picture in the program that wrote it, or its albedo is one colour",
          "set its alphaMode to MASK or BLEND, or remove the alpha channel"};
}

void warn_about_pictures(const MaterialReport& m, const InspectReport& report, Warnings& warnings) {
  const PictureMends mends = picture_mends(report.file);
  const std::string who = "material '" + m.name + "': ";
  bool has_diffuse = false, has_alpha = false;
  for (const PictureReport& p : m.pictures) {
    has_diffuse |= p.use == "diffuse";
    has_alpha |= p.use == "alpha";
  }
  warnings.add(!has_diffuse && !m.has_vertex_colours && m.uv.face_count > 0 && report.missing.empty(),
               who + "no diffuse picture", mends.diffuse);
  warnings.add(m.uv.face_count == 0, who + "no face uses it", "remove it from the file");
  for (const PictureReport& p : m.pictures) {
    const bool is_cut = p.transparent_share > kTransparentShare;
    warnings.add(
        p.use == "diffuse" && is_cut && !has_alpha,
        who + percent(p.transparent_share) + " of the diffuse picture is transparent, but no cut-out is set",
        mends.cut_out);
    warnings.add(p.use == "alpha" && p.transparent_share > kAllTransparent,
                 who + "the cut-out picture is clear wherever faces show it: nothing would be seen",
                 "invert it if white means clear in it; white is opaque here");
    warnings.add(p.use == "alpha" && !is_cut, who + "the cut-out picture is opaque everywhere",
                 "remove it: rays would test it for nothing");
    warnings.add(p.use == "normal" && p.convention.convention == NormalConvention::kDirectX,
                 who + "the normal map is of the DirectX kind (green down)", "flip its green channel");
    warnings.add(p.use == "normal" && p.convention.convention == NormalConvention::kUnclear,
                 who + "the normal map's convention cannot be told for certain (it leans to " +
                     (p.convention.leans_to_opengl() ? "OpenGL)" : "DirectX)"),
                 "make sure that its green points up (OpenGL), as it is taken");
  }
}

}  // namespace

std::vector<Warning> inspect_warnings(const InspectReport& report, bool unit_given) {
  Warnings warnings;
  warnings.list_ = report.missing;
  warnings.add(!report.unit.unit_cm, report.unit.reason, report.unit.mend);
  const double height = static_cast<double>(report.bounds.high.y) - report.bounds.low.y;
  const double height_cm = height * report.unit.unit_cm.value_or(0);
  warnings.add(unit_given && (height_cm > 250 || height_cm < 15),
               "in that unit the scan is " + std::to_string(std::llround(height_cm)) + " cm high",
               "check --unit");
  warnings.add(!report.lying.empty(), report.lying,
               "label, inspect: turn it with --up z (or -z, x, -x); --up y if it is meant to lie");
  warnings.add(!report.facing.empty(),
               "the feet point to " + report.facing + ": the person seems to face there, not +Z",
               "view 0 of a render would not be frontal: turn it about Y in your modelling program");
  for (const MaterialReport& material : report.materials) {
    warn_about_pictures(material, report, warnings);
    if (material.uv.face_count > 0) warn_about_uv(material, warnings);
  }
  warn_about_mesh(report, warnings);
  return warnings.list_;
}

}  // namespace ohb::commands
