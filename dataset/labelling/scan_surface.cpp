#include "dataset/labelling/scan_surface.h"

namespace ohb::labelling {

ScanSurface::ScanSurface(const Scan& of, double cm) : scan(of), unit_cm(cm), topology(mesh_topology(of)) {}

std::vector<Vec3f> ScanSurface::points_cm() const {
  std::vector<Vec3f> points(topology.point_count);
  for (size_t i = scan.positions.size(); i-- > 0;)  // the first of those that were welded
    if (topology.point_of_position[i] != MeshTopology::kNoPoint)
      points[topology.point_of_position[i]] = scan.positions[i] * static_cast<float>(unit_cm);
  return points;
}

}  // namespace ohb::labelling
