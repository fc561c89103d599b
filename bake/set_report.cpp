#include "bake/set_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "bake/texture_set_bake.h"
#include "dataset/model/error.h"

namespace ohb::bake {

void report_geometry(const Model& model, const SetTriangles& triangles,
                     const surface::TexelCoverage& coverage, SetReport& report) {
  report.width_px = coverage.width_px;
  report.height_px = coverage.height_px;
  report.triangles = triangles.index.size();
  report.centre_texels = coverage.centre_texels;
  report.footprint_texels = coverage.footprint_texels;
  report.padded_texels = coverage.owner.size() - coverage.centre_texels - coverage.footprint_texels;
  report.overlapping_texels = coverage.overlapping_texels;
  for (size_t t = 0; t < triangles.index.size(); ++t) {
    const double area = area_cm2(model, model.triangles[triangles.index[t]]);
    const Vec2f* const uv = triangles.uvs[t].uv;
    const double uv_area =
        surface::difference_of_products(double(uv[1].x) - uv[0].x, double(uv[2].y) - uv[0].y,
                                        double(uv[1].y) - uv[0].y, double(uv[2].x) - uv[0].x);
    report.area_cm2 += area;
    if (uv_area < 0) report.mirrored_area_cm2 += area;
    if (uv_area == 0 && area > 0) ++report.triangles_without_uv_area;
    for (int c = 0; c < 3; ++c)
      report.uvs_outside += uv[c].x < 0 || uv[c].x > 1 || uv[c].y < 0 || uv[c].y > 1;
  }
  const std::vector<uint32_t>& hidden = coverage.hidden_triangles;
  for (uint32_t t : coverage.triangles_without_texel) {
    const ModelTriangle& triangle = model.triangles[triangles.index[t]];
    const double area = area_cm2(model, triangle);
    if (!(area > 0)) continue;
    if (std::binary_search(hidden.begin(), hidden.end(), t)) {
      ++report.hidden_triangles;
      continue;
    }
    ++report.triangles_without_texel;
    report.area_without_texel_cm2 += area;
    if (report.faces_without_texel.size() < BakeReport::kListedFaces)
      report.faces_without_texel.push_back(triangle.source_face);
  }
}

void check_overlaps(const SetReport& report, const BakeSource& limits) {
  const double overlaps = static_cast<double>(report.overlapping_texels);
  const double all = static_cast<double>(report.centre_texels);
  if (!(overlaps > limits.max_overlap_share * all)) return;
  throw InputError(
      limits.scan->file.string(), "texture set '" + report.name + "'",
      fmt::format("cannot be baked onto UVs that overlap: {:.2f} % of the texels show more than one "
                  "face; {:.2f} % are allowed",
                  100 * overlaps / all, 100 * limits.max_overlap_share),
      "unwrap the scan, or give --max-overlap PERCENT: such texels then show the first face");
}

void check_misses(const SetReport& report, const SourceBake& source, const BakeSource& limits) {
  const double missed = static_cast<double>(report.missed_texels + report.back_face_texels);
  const double all = missed + static_cast<double>(report.hit_texels + report.nearest_texels);
  if (!(missed > limits.max_missed_share * all)) return;
  const std::string reach =
      source.cage_offset.empty() ? fmt::format("{:.2g} cm", source.inward_cm) : std::string("the cage");
  std::string mend =
      "give a longer --reach, or --max-missed PERCENT to fill them from around and see them in debug.png";
  if (report.back_face_texels > report.missed_texels)
    mend = "turn the faces of the source whose normals point inwards, or say --max-missed PERCENT";
  throw InputError(
      limits.scan->file.string(), "texture set '" + report.name + "'",
      fmt::format("{:.2f} % of its texels find no surface of the source within {} ({:.2f} % find "
                  "only back faces); {:.2f} % are allowed",
                  100 * missed / all, reach, 100 * double(report.back_face_texels) / all,
                  100 * limits.max_missed_share),
      mend);
}

}  // namespace ohb::bake
