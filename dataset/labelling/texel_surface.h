// The texels of a scan's diffuse pictures as pieces of its surface: where they lie, what colour they have,
// and which lie beside each other, in the picture or across a UV seam.
#pragma once

#include "dataset/labelling/face_colours.h"
#include "dataset/labelling/scan_surface.h"
#include "dataset/model/image.h"

namespace ohb::labelling {

/// A texel of a material.
struct SurfaceTexel {
  uint32_t sheet, index;  // row 0 at the top
};

/// Two texels that lie beside each other, and in cm the border that they share.
struct TexelLink {
  SurfaceTexel texel[2];
  Vec3f a, b;
};

class TexelSurface {
 public:
  /// Of the materials with a picture and usable UVs that have wanted faces; pictures finer than
  /// kLeastTexel_cm are averaged. Only texels of wanted faces are there. Throws InputError for a picture that
  /// cannot be read. Keeps a reference to the surface.
  TexelSurface(const ScanSurface& surface, const std::vector<bool>& wanted_faces);

  /// One material's texels.
  struct Sheet {
    size_t material;
    int width, height;

   private:
    friend class TexelSurface;
    struct Steps {  // over the surface of one texel to the right and one down, in cm
      Vec3f right, down;
    };
    MaterialTriangles triangles;
    surface::TexelCoverage coverage;
    Image lab;
    std::vector<Steps> steps;  // of the triangles
  };
  const std::vector<Sheet>& sheets() const { return sheets_; }

  bool is_there(SurfaceTexel texel) const {
    const uint32_t owner = sheets_[texel.sheet].coverage.owner[texel.index];
    return owner != surface::TexelCoverage::kNone && wanted_[sheets_[texel.sheet].triangles.face[owner]];
  }
  /// Of a texel that is there: its face, the point (cm) of it nearest to the texel's centre, CIE L*a*b*, the
  /// longer edge in cm, and the area, 0 where the centre lies beside the face.
  uint32_t face_of(SurfaceTexel texel) const {
    return sheets_[texel.sheet].triangles.face[sheets_[texel.sheet].coverage.owner[texel.index]];
  }
  Vec3f point_of(SurfaceTexel texel) const;
  Vec3f lab_of(SurfaceTexel texel) const {
    const float* const p = &sheets_[texel.sheet].lab.values[3 * size_t{texel.index}];
    return {p[0], p[1], p[2]};
  }
  float edge_cm_of(SurfaceTexel texel) const {
    return std::max(length(steps_at(texel).right), length(steps_at(texel).down));
  }
  float area_cm2_of(SurfaceTexel texel) const;

  /// All pairs, in the order of the sheets; then those across seams.
  std::vector<TexelLink> links() const;

  static constexpr double kLeastTexel_cm = 0.04;  // half a hem

 private:
  const Sheet::Steps& steps_at(SurfaceTexel texel) const {
    return sheets_[texel.sheet].steps[sheets_[texel.sheet].coverage.owner[texel.index]];
  }
  void add_sheet(const std::vector<ScanTriangle>& triangles, size_t material);
  void measure(Sheet& sheet, int width, int height) const;
  void link_within(uint32_t sheet, std::vector<TexelLink>& links) const;
  void link_seams(std::vector<TexelLink>& links) const;
  struct Side;  // of an edge
  Side side_of(const MeshEdge& edge, uint32_t face) const;
  void link_along(const Side& one, const Side& two, std::vector<TexelLink>& links) const;

  const ScanSurface& surface_;
  const Scan& scan_;
  const float unit_cm_;
  const std::vector<bool> wanted_;
  std::vector<Sheet> sheets_;
};

}  // namespace ohb::labelling
