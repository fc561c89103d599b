#include "bake/bake_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace ohb::bake {
namespace {

double share(double part, double whole) {
  return whole > 0 ? part / whole : 0;
}

nlohmann::ordered_json json_of(const MapSeams& seams) {
  const auto list = [](const std::vector<SeamError>& errors) {
    nlohmann::ordered_json levels = nlohmann::ordered_json::array();
    for (const SeamError& error : errors)
      levels.push_back({{"mean", error.mean},
                        {"percentile_99", error.percentile_99},
                        {"max", error.max},
                        {"share_above_limit", error.share_above}});
    return levels;
  };
  nlohmann::ordered_json json{
      {"unit", seams.unit}, {"most_changed_inside", seams.most_changed}, {"levels", list(seams.levels)}};
  if (!seams.shipped_levels.empty()) json["shipped_levels"] = list(seams.shipped_levels);
  return json;
}

/// What the set's UVs cost: texels that are shared, too few, or none.
std::vector<std::string> uv_warnings(const SetReport& set) {
  std::vector<std::string> warnings;
  const double overlap = share(double(set.overlapping_texels), double(set.centre_texels));
  if (overlap > kMaxOverlapShare)
    warnings.push_back(fmt::format(
        "{:.1f} % of its texels show more than one face and {} triangles lie wholly under others "
        "(overlapping "
        "UVs): class and displacement are those of the first face; unwrap again where that matters",
        100 * overlap, set.hidden_triangles));
  const double lost = share(set.area_without_texel_cm2, set.area_cm2);
  if (lost > kMaxTexelLessAreaShare)
    warnings.push_back(
        fmt::format("{:.2f} % of its area is of {} triangles so small that they have no texel of their "
                    "own; bake with a larger --size",
                    100 * lost, set.triangles_without_texel));
  if (set.triangles_without_uv_area > 0)
    warnings.push_back(
        fmt::format("{} triangles have an area but none in UV: each shows one line of texels; unwrap them",
                    set.triangles_without_uv_area));
  if (set.uvs_outside > 0)
    warnings.push_back(
        fmt::format("{} corners have UVs outside [0,1]; the picture is repeated there", set.uvs_outside));
  return warnings;
}

/// What is odd about the normals and pictures that the set was baked from.
std::vector<std::string> source_warnings(const SetReport& set) {
  std::vector<std::string> warnings;
  const double inward = share(double(set.inward_normal_texels), double(set.hit_texels + set.nearest_texels));
  if (inward > kMaxInwardNormalShare)
    warnings.push_back(
        fmt::format("the source's smooth normals point into the scan at {:.1f} % of its texels: its faces do "
                    "not agree on which side is outside; make its normals consistent and export it again",
                    100 * inward));
  if (set.zero_length_normals > 0)
    warnings.push_back(fmt::format("{} pixels of {} hold no direction and became flat",
                                   set.zero_length_normals, set.normal));
  if (!set.mask_size.empty())
    warnings.push_back(fmt::format(
        "its mask {} has another size than its picture ({}): clear pixels are not kept out of the "
        "colours where the map is smaller than the picture; export both in one size",
        set.alpha, set.mask_size));
  if (set.normal_green == "unclear")
    warnings.push_back(
        fmt::format("which way green points in {} cannot be told, it is read as up (OpenGL); say it with "
                    "--normals opengl or directx",
                    set.normal));
  return warnings;
}

nlohmann::ordered_json json_of(const SetReport& set, bool has_source) {
  nlohmann::ordered_json json = {{"name", set.name},
                                 {"folder", set.folder},
                                 {"width_px", set.width_px},
                                 {"height_px", set.height_px},
                                 {"triangles", set.triangles},
                                 {"centre_texels", set.centre_texels},
                                 {"footprint_texels", set.footprint_texels},
                                 {"padded_texels", set.padded_texels},
                                 {"overlapping_texels", set.overlapping_texels},
                                 {"hidden_triangles", set.hidden_triangles},
                                 {"triangles_without_texel", set.triangles_without_texel},
                                 {"faces_without_texel", set.faces_without_texel},
                                 {"triangles_without_uv_area", set.triangles_without_uv_area},
                                 {"uvs_outside", set.uvs_outside},
                                 {"area_cm2", set.area_cm2},
                                 {"mirrored_area_cm2", set.mirrored_area_cm2},
                                 {"area_without_texel_cm2", set.area_without_texel_cm2},
                                 {"diffuse", set.diffuse},
                                 {"alpha", set.alpha},
                                 {"normal", set.normal},
                                 {"normal_green", set.normal_green},
                                 {"zero_length_normals", set.zero_length_normals}};
  json["seam_edges"] = set.seam_edges;
  json["seam_edges_left_out"] = set.seam_edges_left_out;
  for (const MapSeams& seams : set.seams) json["seams"][seams.map] = json_of(seams);
  if (has_source)
    json["source"] = {{"hit_texels", set.hit_texels},
                      {"nearest_texels", set.nearest_texels},
                      {"missed_texels", set.missed_texels},
                      {"back_face_texels", set.back_face_texels},
                      {"inward_normal_texels", set.inward_normal_texels},
                      {"mean_distance_cm", set.mean_distance_cm},
                      {"max_distance_cm", set.max_distance_cm}};
  return json;
}

}  // namespace

std::vector<std::string> warnings_of(const BakeReport& report) {
  std::vector<std::string> warnings;
  if (report.repeated_faces > 0)
    warnings.push_back(fmt::format(
        "{} left out: exact copies of others, which would throw shadows on each other in "
        "Blender; remove them from the scan too",
        report.repeated_faces == 1 ? "1 face of the scan was"
                                   : fmt::format("{} faces of the scan were", report.repeated_faces)));
  for (const SetReport& set : report.sets) {
    const auto warn = [&](const std::string& text) { warnings.push_back("set '" + set.name + "': " + text); };
    for (const std::string& text : uv_warnings(set)) warn(text);
    for (const std::string& text : source_warnings(set)) warn(text);
    if (set.centre_texels == 0)
      warn("no face covers the centre of any texel; bake with a larger --size or unwrap again");
  }
  return warnings;
}

nlohmann::ordered_json to_json(const BakeReport& report) {
  nlohmann::ordered_json json;
  json["scan"] = report.scan;
  json["scan_sha256"] = report.scan_sha256;
  json["unit_cm"] = report.unit_cm;
  json["unit_reason"] = report.unit_reason;
  json["shift_cm"] = report.shift_cm;
  json["size_cm"] = report.size_cm;
  json["triangles"] = report.triangles;
  json["positions"] = report.positions;
  json["repeated_faces"] = report.repeated_faces;
  if (!report.source.empty())
    json["source"] = {{"file", report.source},
                      {"sha256", report.source_sha256},
                      {"unit_cm", report.source_unit_cm},
                      {"triangles", report.source_triangles},
                      {"outward_cm", report.outward_cm},
                      {"inward_cm", report.inward_cm}};
  json["limits"] = {{"overlap_share", kMaxOverlapShare},
                    {"area_without_texel_share", kMaxTexelLessAreaShare}};
  json["sets"] = nlohmann::ordered_json::array();
  for (const SetReport& set : report.sets) json["sets"].push_back(json_of(set, !report.source.empty()));
  json["warnings"] = warnings_of(report);
  return json;
}

std::string to_text(const BakeReport& report) {
  std::string text = fmt::format("{}: {} triangles, {:.1f} x {:.1f} x {:.1f} cm, {} texture set{}\n",
                                 report.scan, report.triangles, report.size_cm[0], report.size_cm[1],
                                 report.size_cm[2], report.sets.size(), report.sets.size() == 1 ? "" : "s");
  if (!report.unit_reason.empty())
    text += fmt::format("  unit: {} cm ({})\n", report.unit_cm, report.unit_reason);
  if (!report.source.empty())
    text += fmt::format("  source: {}, {} triangles, sought within {:.3g} cm\n", report.source,
                        report.source_triangles, report.inward_cm);
  for (const SetReport& set : report.sets) {
    const double texels = double(set.width_px) * set.height_px;
    text += fmt::format(
        "  {:<16} {} x {}: {:.1f} % covered, {:.1f} % at borders, {:.1f} % padded, {:.2f} % overlapping, "
        "{} triangles without a texel\n",
        set.name, set.width_px, set.height_px, 100 * double(set.centre_texels) / texels,
        100 * double(set.footprint_texels) / texels, 100 * double(set.padded_texels) / texels,
        100 * share(double(set.overlapping_texels), double(set.centre_texels)), set.triangles_without_texel);
    if (!report.source.empty())
      text += fmt::format(
          "  {:<16} from the source: {} texels hit, {} by nearest point, {} missed, {} back faces only; "
          "{:.3f} "
          "cm away on average, at most {:.3f}\n",
          "", set.hit_texels, set.nearest_texels, set.missed_texels, set.back_face_texels,
          set.mean_distance_cm, set.max_distance_cm);
  }
  for (const std::string& warning : warnings_of(report)) text += "warning: " + warning + "\n";
  return text;
}

}  // namespace ohb::bake
