// How far a point of the surface is from the borders between classes.
#pragma once

#include <vector>

#include "dataset/labelling/alpha_expansion.h"
#include "dataset/labelling/scan_surface.h"

namespace ohb::labelling {

/// A piece of the border of two classes, as the side of `own` sees it.
struct BorderPiece {
  uint32_t face, beyond;  // of that side, and of the other
  uint8_t own, other;     // classes
  Vec3f a, b;             // cm, in the scan's axes
};

/// The edges that faces of two classes share on the welded mesh, once from each side.
std::vector<BorderPiece> borders_of_faces(const ScanSurface& surface, const std::vector<uint8_t>& face_class);

/// One bit a class that occurs in the face: its own; none without a class.
std::vector<uint8_t> class_bits(const std::vector<uint8_t>& face_class);

class BorderDistance {
 public:
  using Reach = std::array<std::array<float, kClassCount>, kClassCount>;

  /// `classes_of_face`: one bit a class that occurs in the face. `reach_cm[own][other]`: how far pieces of
  /// that pair matter.
  BorderDistance(const ScanSurface& surface, const std::vector<BorderPiece>& pieces,
                 const std::vector<uint8_t>& classes_of_face, const Reach& reach_cm);

  /// Whether a border is within reach of some point of the face.
  bool is_near(uint32_t face) const { return first_[face] < first_[face + 1]; }

  /// In cm: from a point (in cm) of a face, at which the class is `own`, to the nearest border with each
  /// other class that faces with that class connect within reach, so across a fold nothing is near. Infinite
  /// where there is none.
  ClassValues distances_at(uint32_t face, uint8_t own, Vec3f point_cm) const;

 private:
  std::vector<uint32_t> first_;  // pieces of face f: [first_[f], first_[f + 1])
  std::vector<BorderPiece> pieces_;
};

}  // namespace ohb::labelling
