// Colours at the vertices of formats that have no word for what becomes of them (OBJ, FBX).
#include <set>

#include "dataset/model/scan_readers.h"

namespace ohb {

void settle_vertex_colours(Scan& scan, std::vector<bool> is_coloured) {
  scan.corner_colours.resize(scan.corners.size());
  is_coloured.resize(scan.face_count(), false);
  std::set<uint16_t> used, unused;
  for (size_t f = 0; f < scan.face_count(); ++f)
    if (is_coloured[f])
      (scan.materials[scan.face_material[f]].diffuse.empty() ? used : unused).insert(scan.face_material[f]);
  for (size_t f = 0; f < scan.face_count(); ++f) {
    const uint16_t material = scan.face_material[f];
    for (size_t c = scan.face_begin[f]; c < scan.face_begin[f + 1]; ++c) {
      if (used.count(material) == 0) scan.corner_colours[c] = {};
      if (used.count(material) && !is_coloured[f])
        scan.corner_colours[c] = {scan.materials[material].diffuse_factor, 1};
    }
  }
  for (uint16_t material : used) {
    scan.materials[material].diffuse_factor = {1, 1, 1};
    scan.notes.push_back("material '" + scan.materials[material].name +
                         "' has no picture: the colours at its vertices are taken");
  }
  for (uint16_t material : unused)
    scan.notes.push_back("material '" + scan.materials[material].name +
                         "': the colours at its vertices are not used, its picture is");
  if (used.empty()) scan.corner_colours.clear();
}

}  // namespace ohb
