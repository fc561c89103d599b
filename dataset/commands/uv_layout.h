// How a scan's faces lie in UV space: coverage, overlaps, flips, tiles, charts.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "dataset/model/mesh_topology.h"
#include "dataset/model/scan.h"

namespace ohb::commands {

/// Shares are of the unit tile or of the faces' UV area, 0 to 1.
struct UvLayout {
  size_t face_count = 0, faces_without_uv = 0, zero_area_faces = 0;
  size_t faces_outside = 0;  // centroid outside [0,1] x [0,1]
  std::vector<int> tiles;    // UDIM tiles (1001 + floor u + 10 floor v) of the centroids, up to 100 of them
  double flipped_share = 0;  // area whose winding in UV is opposite to that of the face
  bool is_measured = false;  // coverage and overlap are known; false if faces cover the picture too often
  int grid_px = 0;           // they were measured at that many texel centres squared
  double coverage = 0;       // of the unit tile's texels, UVs repeated
  double overlap_share = 0;  // of the covered texels: those that faces without a common vertex share
};

/// How much a measurement may cost: texel centres squared, and tests of a face against one, above which it
/// takes a coarser grid (halved as often as it must be).
struct UvGrid {
  int size_px = 2048;
  double max_tests = 1e8;  // less than a second
};

/// The faces of each material, and their triangles.
struct MaterialFaces {
  std::vector<uint32_t> faces;
  std::vector<ScanTriangle> triangles;
};
std::vector<MaterialFaces> faces_of_materials(const Scan& scan, const std::vector<ScanTriangle>& triangles);

/// The layout of one material's faces.
UvLayout measure_uv_layout(const Scan& scan, const MaterialFaces& material, const MeshTopology& topology,
                           UvGrid grid = {});

/// For each texel (row 0 at the top, v up) the face whose UVs cover its centre, or kNoFace: the earlier face
/// where several do. Faces that share an edge never both cover a texel. Where faces cover the picture so
/// often that this would take more than `max_tests`, blocks of texels take the face at the middle of the
/// block.
constexpr uint32_t kNoFace = 0xffffffffu;
struct UvRaster {
  std::vector<uint32_t> face;
  size_t covered = 0,
         overlapping = 0;  // overlapping: hit again by a face that shares no vertex with the first
};
struct RasterSize {
  int width_px, height_px;
  double max_tests = 4e8;  // as UvGrid's
};
UvRaster rasterise_uvs(const Scan& scan, const std::vector<ScanTriangle>& triangles,
                       const MeshTopology& topology, uint16_t material, const RasterSize& size);

/// Faces of the same material that are joined in UV space (they share an edge of the same two UV indices).
std::vector<uint32_t> uv_charts(const Scan& scan);

}  // namespace ohb::commands
