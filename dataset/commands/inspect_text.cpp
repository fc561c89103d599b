// The inspect report as a table and as JSON.
#include <cstdarg>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "dataset/commands/inspect.h"

namespace ohb::commands {
namespace {

using nlohmann::ordered_json;

__attribute__((format(printf, 1, 2))) std::string formatted(const char* format, ...) {
  char text[512];
  va_list values;
  va_start(values, format);
  std::vsnprintf(text, sizeof text, format, values);
  va_end(values);
  return text;
}

std::string row(const char* label, const std::string& value) {
  return formatted("%-12s", label) + value + "\n";
}

std::string short_name(const std::string& file) {
  const size_t embedded = file.rfind('#');
  const std::string name = std::filesystem::path(file).filename().string();
  return embedded == std::string::npos ? name : "embedded " + file.substr(embedded + 1);
}

std::string picture_line(const PictureReport& p) {
  std::string line = formatted("  %-8s %s, %d x %d, %d channels, %d bit%s", p.use.c_str(),
                               short_name(p.file).c_str(), p.info.width_px, p.info.height_px, p.info.channels,
                               p.info.bits, p.info.is_float ? " float" : "");
  if (p.use == "normal")
    line +=
        formatted("; convention: %s (curl ratio %.1f)", name_of(p.convention.convention), p.convention.ratio);
  if (p.is_cut_out) line += formatted("; %.3g %% transparent", 100 * p.transparent_share);
  return line + "\n";
}

std::string size_text(const InspectReport& r) {
  const Vec3f e = r.bounds.high - r.bounds.low;
  std::string text = formatted("%.6g x %.6g x %.6g units (X, Y, Z)", e.x, e.y, e.z);
  if (r.unit.unit_cm)
    text += formatted(" = %.5g x %.5g x %.5g cm", e.x * *r.unit.unit_cm, e.y * *r.unit.unit_cm,
                      e.z * *r.unit.unit_cm);
  return text;
}

ordered_json vector_json(Vec3f v, double scale = 1) {
  return {v.x * scale, v.y * scale, v.z * scale};
}

ordered_json picture_json(const PictureReport& p) {
  ordered_json json = {{"use", p.use},
                       {"file", p.file},
                       {"width_px", p.info.width_px},
                       {"height_px", p.info.height_px},
                       {"channels", p.info.channels},
                       {"bits", p.info.bits},
                       {"is_float", p.info.is_float},
                       {"has_alpha", p.info.has_alpha}};
  if (p.use == "normal") {
    json["convention"] = name_of(p.convention.convention);
    json["curl_ratio"] = p.convention.ratio;
    json["curl_opengl"] = p.convention.curl_opengl;
    json["curl_directx"] = p.convention.curl_directx;
  } else if (p.is_cut_out) {
    json["transparent_share"] = p.transparent_share;
  }
  return json;
}

ordered_json material_json(const MaterialReport& m) {
  ordered_json json = {{"name", m.name},
                       {"faces", m.uv.face_count},
                       {"faces_without_uv", m.uv.faces_without_uv},
                       {"zero_uv_area_faces", m.uv.zero_area_faces},
                       {"faces_outside_unit_square", m.uv.faces_outside},
                       {"udim_tiles", m.uv.tiles},
                       {"flipped_uv_share", m.uv.flipped_share}};
  json["uv_coverage"] = m.uv.is_measured ? ordered_json(m.uv.coverage) : ordered_json();
  json["uv_overlap_share"] = m.uv.is_measured ? ordered_json(m.uv.overlap_share) : ordered_json();
  json["opacity"] = m.opacity;
  json["alpha_cutoff"] = m.alpha_cutoff ? ordered_json(*m.alpha_cutoff) : ordered_json();
  json["has_vertex_colours"] = m.has_vertex_colours;
  json["uv_grid_px"] = m.uv.grid_px;
  json["pictures"] = ordered_json::array();
  for (const PictureReport& p : m.pictures) json["pictures"].push_back(picture_json(p));
  return json;
}

}  // namespace

std::string inspect_text(const InspectReport& r) {
  std::string text = r.file + "\n";
  text += row("vertices", formatted("%zu (%zu after welding, %zu unused), %zu UVs", r.vertices, r.points,
                                    r.unused_vertices, r.uvs));
  text += row("faces", formatted("%zu: %zu triangles, %zu quads, %zu larger; %zu triangles in all", r.faces,
                                 r.triangle_faces, r.quad_faces, r.larger_faces, r.triangles));
  text += row("size", size_text(r));
  text += row("unit", (r.unit.unit_cm ? formatted("%g cm: ", *r.unit.unit_cm) : "unknown: ") + r.unit.reason);
  text += row("surface", formatted("%zu pieces (%zu small), %zu border edges in %zu holes or rims",
                                   r.components, r.small_components, r.border_edges, r.holes));
  text += row("faults",
              formatted("%zu non-manifold edges, %zu inconsistent edges, %zu duplicate faces, %zu faces "
                        "without area",
                        r.non_manifold_edges, r.inconsistent_edges, r.duplicate_faces, r.zero_area_faces));
  std::string groups;
  for (size_t i = 0; i < r.groups.size() && i < 12; ++i) groups += (i ? ", " : "") + r.groups[i];
  if (r.groups.size() > 12) groups += formatted(", ... %zu in all", r.groups.size());
  text += row("groups", groups);
  text += row("normals", r.has_file_normals ? "in the file, not used: normals are smooth over shared vertices"
                                            : "not in the file: normals are smooth over shared vertices");
  for (const MaterialReport& m : r.materials) {
    text += formatted("material %s: %zu faces", m.name.substr(0, 100).c_str(), m.uv.face_count);
    if (m.uv.is_measured && m.uv.face_count > m.uv.faces_without_uv)
      text += formatted(", UVs cover %.3g %% of the picture, %.3g %% of that overlaps, %.3g %% is mirrored",
                        100 * m.uv.coverage, 100 * m.uv.overlap_share, 100 * m.uv.flipped_share);
    if (m.uv.is_measured && m.uv.grid_px < UvGrid().size_px)
      text += formatted(" (estimated at %d x %d points: more would take long)", m.uv.grid_px, m.uv.grid_px);
    text += "\n";
    for (const PictureReport& p : m.pictures) text += picture_line(p);
    if (m.opacity < 1) text += formatted("  opacity  %.3g\n", m.opacity);
    if (m.alpha_cutoff) text += formatted("  opacity  1 from %.3g on, else 0\n", *m.alpha_cutoff);
    if (m.has_vertex_colours) text += "  colours  at the vertices\n";
  }
  for (const std::string& note : r.notes) text += "note: " + note + "\n";
  for (const Warning& w : r.warnings)
    text += "warning: " + w.what + (w.mend.empty() ? "" : "; ") + w.mend + "\n";
  if (r.warnings.empty()) text += "no warnings\n";
  return text;
}

ordered_json inspect_json(const InspectReport& r) {
  ordered_json json = {{"file", r.file},
                       {"vertices", r.vertices},
                       {"welded_vertices", r.points},
                       {"unused_vertices", r.unused_vertices},
                       {"uvs", r.uvs},
                       {"faces", r.faces},
                       {"triangle_faces", r.triangle_faces},
                       {"quad_faces", r.quad_faces},
                       {"larger_faces", r.larger_faces},
                       {"triangles", r.triangles},
                       {"groups", r.groups},
                       {"has_file_normals", r.has_file_normals},
                       {"bounds_low", vector_json(r.bounds.low)},
                       {"bounds_high", vector_json(r.bounds.high)}};
  json["unit_cm"] = r.unit.unit_cm ? ordered_json(*r.unit.unit_cm) : ordered_json();
  json["unit_reason"] = r.unit.reason;
  if (r.unit.unit_cm) json["size_cm"] = vector_json(r.bounds.high - r.bounds.low, *r.unit.unit_cm);
  json["pieces"] = r.components;
  json["small_pieces"] = r.small_components;
  json["border_edges"] = r.border_edges;
  json["holes"] = r.holes;
  json["non_manifold_edges"] = r.non_manifold_edges;
  json["inconsistent_edges"] = r.inconsistent_edges;
  json["duplicate_faces"] = r.duplicate_faces;
  json["repeated_vertex_faces"] = r.repeated_vertex_faces;
  json["zero_area_faces"] = r.zero_area_faces;
  json["materials"] = ordered_json::array();
  for (const MaterialReport& m : r.materials) json["materials"].push_back(material_json(m));
  if (r.removed_offset)
    json["removed_offset"] = {r.removed_offset->x, r.removed_offset->y, r.removed_offset->z};
  json["notes"] = r.notes;
  json["warnings"] = ordered_json::array();
  for (const Warning& w : r.warnings) json["warnings"].push_back({{"what", w.what}, {"mend", w.mend}});
  return json;
}

}  // namespace ohb::commands
