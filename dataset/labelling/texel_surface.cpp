#include "dataset/labelling/texel_surface.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "dataset/model/lab_colour.h"
#include "dataset/surface/picture.h"
#include "dataset/surface/vertex_colours.h"

namespace ohb::labelling {
namespace {

constexpr uint32_t kNoSheet = 0xffffffffu;
/// Texels beside each other in the picture that lie farther apart than this many steps are of two charts.
constexpr float kMostSteps = 3;

size_t texel_under(int width, int height, Vec2f uv) {
  const auto index = [](float coordinate, int size) {
    const double part = double(coordinate) - std::floor(double(coordinate));
    return std::min(static_cast<int>(part * size), size - 1);
  };
  return static_cast<size_t>(height - 1 - index(uv.y, height)) * width +
         static_cast<size_t>(index(uv.x, width));
}

}  // namespace

TexelSurface::TexelSurface(const ScanSurface& surface, const std::vector<bool>& wanted_faces)
    : surface_(surface),
      scan_(surface.scan),
      unit_cm_(static_cast<float>(surface.unit_cm)),
      wanted_(wanted_faces) {
  const std::vector<ScanTriangle> triangles = triangulate(scan_);
  for (size_t m = 0; m < scan_.materials.size(); ++m)
    if (!scan_.materials[m].diffuse.empty()) add_sheet(triangles, m);
}

void TexelSurface::measure(Sheet& sheet, int width, int height) const {
  sheet.width = width;
  sheet.height = height;
  sheet.steps.clear();
  for (size_t t = 0; t < sheet.triangles.face.size(); ++t) {
    const auto& uv = sheet.triangles.uvs[t].uv;
    const auto corner = [&](size_t i) {
      return scan_.positions[scan_.corners[sheet.triangles.corners[t][i]].position] * unit_cm_;
    };
    const Vec3f one = corner(1) - corner(0), two = corner(2) - corner(0);
    const double ax = (double(uv[1].x) - uv[0].x) * width, ay = (double(uv[1].y) - uv[0].y) * height,
                 bx = (double(uv[2].x) - uv[0].x) * width, by = (double(uv[2].y) - uv[0].y) * height;
    const double determinant = ax * by - ay * bx;
    if (!(std::abs(determinant) > 1e-12)) {
      sheet.steps.emplace_back();
      continue;
    }
    // One texel right is (by, -ay) / determinant of (one, two), one up (-bx, ax) / determinant.
    const auto share = [&](double value) { return static_cast<float>(value / determinant); };
    sheet.steps.push_back({share(by) * one + share(-ay) * two, share(bx) * one + share(-ax) * two});
  }
}

void TexelSurface::add_sheet(const std::vector<ScanTriangle>& triangles, size_t material) {
  Sheet sheet;
  sheet.material = material;
  sheet.triangles = material_triangles(scan_, triangles, material);
  const auto is_wanted = [&](uint32_t face) { return bool(wanted_[face]); };
  if (sheet.triangles.unusable > 0 ||
      std::none_of(sheet.triangles.face.begin(), sheet.triangles.face.end(), is_wanted))
    return;
  sheet.lab = surface::read_colour_picture(scan_.materials[material].diffuse);
  if (scan_.materials[material].has_vertex_colours)
    surface::multiply_vertex_colours(
        scan_, sheet.triangles.corners, sheet.triangles.uvs,
        surface::cover_texels(sheet.triangles.uvs, sheet.lab.width_px, sheet.lab.height_px), sheet.lab);
  measure(sheet, sheet.lab.width_px, sheet.lab.height_px);
  std::vector<float> edges;
  for (size_t t = 0; t < sheet.steps.size(); ++t)
    if (is_wanted(sheet.triangles.face[t]))
      edges.push_back(std::sqrt(length(sheet.steps[t].right) * length(sheet.steps[t].down)));
  const auto middle = edges.begin() + static_cast<ptrdiff_t>(edges.size() / 2);
  std::nth_element(edges.begin(), middle, edges.end());
  int halvings = 0;
  for (double edge = *middle; edge > 0 && 2 * edge <= 1.5 * kLeastTexel_cm; edge *= 2) ++halvings;
  if (halvings > 0) {
    const int width = std::max(1, sheet.width >> halvings), height = std::max(1, sheet.height >> halvings);
    sheet.lab = surface::resample(std::move(sheet.lab), width, height);
    measure(sheet, width, height);
  }
  sheet.coverage = surface::cover_texels(sheet.triangles.uvs, sheet.width, sheet.height);
  sheets_.push_back(std::move(sheet));
  Sheet& kept = sheets_.back();
  const auto s = static_cast<uint32_t>(sheets_.size() - 1);
  tbb::parallel_for(0, kept.height, [&](int y) {
    for (int x = 0; x < kept.width; ++x) {
      if (!is_there({s, static_cast<uint32_t>(y * kept.width + x)})) continue;
      float* const p = kept.lab.pixel(x, y);
      const Vec3f lab = linear_to_lab({p[0], p[1], p[2]});
      std::copy_n(&lab.x, 3, p);
    }
  });
}

Vec3f TexelSurface::point_of(SurfaceTexel texel) const {
  const Sheet& sheet = sheets_[texel.sheet];
  const uint32_t owner = sheet.coverage.owner[texel.index];
  const surface::NearestPoint nearest =
      surface::shown_point(sheet.coverage, sheet.triangles.uvs, static_cast<int>(texel.index) % sheet.width,
                           static_cast<int>(texel.index) / sheet.width);
  Vec3f point;
  for (size_t c = 0; c < 3; ++c)
    point += static_cast<float>(nearest.weights[c]) *
             scan_.positions[scan_.corners[sheet.triangles.corners[owner][c]].position];
  return point * unit_cm_;
}

float TexelSurface::area_cm2_of(SurfaceTexel texel) const {
  const bool is_in = sheets_[texel.sheet].coverage.flags[texel.index] & surface::TexelCoverage::kCentre;
  return is_in ? length(cross(steps_at(texel).right, steps_at(texel).down)) : 0;
}

std::vector<TexelLink> TexelSurface::links() const {
  std::vector<TexelLink> links;
  for (uint32_t s = 0; s < sheets_.size(); ++s) link_within(s, links);
  link_seams(links);
  return links;
}

void TexelSurface::link_within(uint32_t s, std::vector<TexelLink>& links) const {
  const Sheet& sheet = sheets_[s];
  std::vector<std::vector<TexelLink>> rows(static_cast<size_t>(sheet.height));
  tbb::parallel_for(0, sheet.height, [&](int y) {
    for (int x = 0; x < sheet.width; ++x) {
      const SurfaceTexel texel{s, static_cast<uint32_t>(y * sheet.width + x)};
      if (!is_there(texel)) continue;
      const Sheet::Steps& steps = steps_at(texel);
      const Vec3f point = point_of(texel);
      const auto link_to = [&](SurfaceTexel other, Vec3f step, Vec3f side) {
        if (!is_there(other)) return;
        const bool is_in_one = sheet.coverage.owner[other.index] == sheet.coverage.owner[texel.index];
        if (!is_in_one && length(point_of(other) - point) > kMostSteps * (length(step) + 1e-6f)) return;
        const Vec3f middle = point + 0.5f * step;
        rows[y].push_back({{texel, other}, middle - 0.5f * side, middle + 0.5f * side});
      };
      if (x + 1 < sheet.width) link_to({s, texel.index + 1}, steps.right, steps.down);
      if (y + 1 < sheet.height)
        link_to({s, texel.index + static_cast<uint32_t>(sheet.width)}, steps.down, steps.right);
    }
  });
  for (const auto& row : rows) links.insert(links.end(), row.begin(), row.end());
}

/// What a face knows of one of its edges.
struct TexelSurface::Side {
  uint32_t sheet = kNoSheet, face = 0;
  Vec2f uv[2], middle_uv;  // of the edge's ends, and of the face's corners
  Vec3f at[2];             // cm
};

TexelSurface::Side TexelSurface::side_of(const MeshEdge& edge, uint32_t face) const {
  Side side;
  side.face = face;
  if (!wanted_[face]) return side;
  for (uint32_t s = 0; s < sheets_.size(); ++s)
    if (sheets_[s].material == scan_.face_material[face]) side.sheet = s;
  if (side.sheet == kNoSheet) return side;
  const uint32_t begin = scan_.face_begin[face], last = scan_.face_begin[face + 1];
  for (uint32_t c = begin; c < last; ++c) {
    side.middle_uv =
        side.middle_uv + (1.0f / static_cast<float>(last - begin)) * scan_.uvs[scan_.corners[c].uv];
    for (int end = 0; end < 2; ++end)
      if (surface_.topology.point_of_position[scan_.corners[c].position] == edge.point[end]) {
        side.uv[end] = scan_.uvs[scan_.corners[c].uv];
        side.at[end] = scan_.positions[scan_.corners[c].position] * unit_cm_;
      }
  }
  return side;
}

void TexelSurface::link_seams(std::vector<TexelLink>& links) const {
  const auto is_same = [](Vec2f l, Vec2f r) { return l.x == r.x && l.y == r.y; };
  for (const MeshEdge& edge : surface_.topology.edges)
    for (uint32_t u = 1; u < edge.use_count; ++u) {
      const Side one = side_of(edge, surface_.topology.uses[edge.first_use + u - 1].face),
                 two = side_of(edge, surface_.topology.uses[edge.first_use + u].face);
      if (one.sheet == kNoSheet || two.sheet == kNoSheet || one.face == two.face) continue;
      if (one.sheet != two.sheet || !is_same(one.uv[0], two.uv[0]) || !is_same(one.uv[1], two.uv[1]))
        link_along(one, two, links);
    }
}

/// At each texel's width along a seam.
void TexelSurface::link_along(const Side& one, const Side& two, std::vector<TexelLink>& links) const {
  const auto texels_of = [&](const Side& side) {
    const Vec2f along = side.uv[1] - side.uv[0];
    return std::max(std::abs(along.x) * static_cast<float>(sheets_[side.sheet].width),
                    std::abs(along.y) * static_cast<float>(sheets_[side.sheet].height));
  };
  const int count = std::max(1, static_cast<int>(std::ceil(std::max(texels_of(one), texels_of(two)))));
  for (int i = 0; i < count; ++i) {
    const float from = static_cast<float>(i) / static_cast<float>(count),
                to = static_cast<float>(i + 1) / static_cast<float>(count);
    TexelLink link;
    link.a = one.at[0] + from * (one.at[1] - one.at[0]);
    link.b = one.at[0] + to * (one.at[1] - one.at[0]);
    // A texel that shows another part, where UVs overlap, is no neighbour.
    const auto find = [&](const Side& side, SurfaceTexel& texel) {
      const Sheet& sheet = sheets_[side.sheet];
      const Vec2f on = side.uv[0] + 0.5f * (from + to) * (side.uv[1] - side.uv[0]);
      const Vec2f inwards = side.middle_uv - on;
      const float texels = std::max(std::abs(inwards.x) * static_cast<float>(sheet.width),
                                    std::abs(inwards.y) * static_cast<float>(sheet.height));
      const Vec2f uv = on + (0.25f / std::max(texels, 0.25f)) * inwards;  // not of what lies beyond the seam
      texel = {side.sheet, static_cast<uint32_t>(texel_under(sheet.width, sheet.height, uv))};
      return is_there(texel) && length(point_of(texel) - 0.5f * (link.a + link.b)) <=
                                    kMostSteps * edge_cm_of(texel) + length(link.b - link.a);
    };
    if (find(one, link.texel[0]) && find(two, link.texel[1]) &&
        (one.sheet != two.sheet || link.texel[0].index != link.texel[1].index))
      links.push_back(link);
  }
}

}  // namespace ohb::labelling
