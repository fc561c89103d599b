// A scan as one surface: its welded mesh and its size. Made once a command; what labels a scan shares it.
#pragma once

#include <vector>

#include "dataset/model/mesh_topology.h"
#include "dataset/model/scan.h"

namespace ohb::labelling {

struct ScanSurface {
  /// `unit_cm`: cm a unit of the scan. Keeps a reference: the scan must outlive it.
  ScanSurface(const Scan& scan, double unit_cm);

  /// The position of each welded point in cm, in the scan's axes.
  std::vector<Vec3f> points_cm() const;

  const Scan& scan;
  const double unit_cm;
  const MeshTopology topology;
};

}  // namespace ohb::labelling
