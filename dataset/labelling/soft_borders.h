// Soft borders: the shares of the classes near where two classes meet, as wide as the two blend into each
// other on people.
#pragma once

#include <vector>

#include "dataset/labelling/border_distance.h"
#include "dataset/labelling/class_pairs.h"

namespace ohb::labelling {

class SoftBorders {
 public:
  /// Borders are the edges that faces of two classes share on the welded mesh; where parts only touch,
  /// borders stay hard.
  SoftBorders(const ScanSurface& surface, const std::vector<uint8_t>& face_class);
  /// Other borders: `classes_of_face` has one bit a class that occurs in the face.
  SoftBorders(const ScanSurface& surface, const std::vector<BorderPiece>& pieces,
              const std::vector<uint8_t>& classes_of_face);

  /// Whether a border is so near that some point of the face is a mixture.
  bool is_near(uint32_t face) const { return distance_.is_near(face); }

  /// The shares of the classes at a point of a face, in the scan's unit, whose class is `own`. From 1/2 and
  /// 1/2 on a border of two, linear in the distance to it (that of the nearest piece of border that the
  /// surface connects within half the width, so across a fold nothing blends); sums to 1. Where several
  /// borders meet their odds add up. All 0 without a class.
  ClassValues shares_at(uint32_t face, uint8_t own, Vec3f point) const;

 private:
  float unit_cm_;
  BorderDistance distance_;
};

}  // namespace ohb::labelling
