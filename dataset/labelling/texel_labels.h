// Class borders finer than the faces: in a band along the borders between faces each texel takes its own
// class, so that a border follows the picture where it cuts through faces.
//
// Energy of the labels l over texels t and the pairs (t, u) that lie beside each other, in the picture or
// across a UV seam:
//   sum_t A_t [ -k_colour log G_l(t) + k_way (d_l(t) / band)^2 ] + k_border sum_tu b_tu w_tu [l_t != l_u]
// A area, b length of the shared border, G the probability by the colours of the classes near by on this
// person, d the way that the border of the faces would have to come, w the likeness of the colours. Texels
// beyond the band keep the class of their face, and so do islands and all where the colours beside the border
// that comes out cannot be told from each other.
#pragma once

#include "dataset/labelling/border_distance.h"

namespace ohb::labelling {

/// Width and height of a material's class map: those of its diffuse picture, at most kMaxClassMapEdge_px;
/// kClassMapWithoutPicture_px without one.
std::pair<int, int> class_map_size(const ScanMaterial& material);
constexpr int kMaxClassMapEdge_px = 8192, kClassMapWithoutPicture_px = 1024;

/// Of one material: the classes of the texels in the band, on a grid over its whole picture.
struct TexelGrid {
  static constexpr uint32_t kNone = 0xffffffffu;
  int width = 0, height = 0;   // 0: no texel of this material is in a band
  std::vector<uint32_t> node;  // of each texel, row 0 at the top; kNone outside of the band
};

class TexelLabels {
 public:
  /// What a refinement did.
  struct Summary {
    bool is_refined = false;
    std::string reason;      // why it is not
    double edge_cm = 0;      // mean length of the faces' edges on borders, weighed by length
    double texel_cm = 0;     // mean edge of the texels in the band
    double band_cm = 0;      // half its width
    double border_cm = 0;    // length of the borders between faces
    uint64_t texels = 0;     // in the band
    double changed_cm2 = 0;  // that left the class of their face

    /// Mean way of the borders.
    double shift_mm() const { return border_cm > 0 ? 10 * changed_cm2 / border_cm : 0; }
  };

  /// `fixed_faces` (one each, or empty) keep their class. With `only_if_coarse` nothing is done where edges
  /// are so short that a border along them is as good. Faces without a picture, usable UVs or class stay as
  /// they are. Throws InputError for a picture that cannot be read.
  TexelLabels(const ScanSurface& surface, const std::vector<uint8_t>& face_class,
              const std::vector<bool>& fixed_faces, bool only_if_coarse);

  /// The class at a point (cm) of a face that the texel at (x, y), in shares of the picture from its upper
  /// left, shows.
  uint8_t class_at(size_t material, uint32_t face, double x, double y, Vec3f point_cm) const;
  /// Whether some texel of the face may have another class than it.
  bool is_refined(uint32_t face) const { return !is_refined_.empty() && is_refined_[face]; }

  /// All borders now, and the classes that occur in each face, a bit each: for SoftBorders.
  const std::vector<BorderPiece>& borders() const { return borders_; }
  const std::vector<uint8_t>& classes_of_face() const { return classes_of_face_; }
  const Summary& summary() const { return summary_; }

 private:
  friend class TexelSolve;
  std::vector<uint8_t> face_class_;
  std::vector<bool> is_refined_;
  std::vector<TexelGrid> grids_;
  std::vector<uint8_t> node_class_;
  std::vector<Vec3f> node_point_cm_;
  std::vector<float> node_edge_cm_;  // the longer one of the texel
  std::vector<BorderPiece> borders_;
  std::vector<uint8_t> classes_of_face_;
  Summary summary_;
};

}  // namespace ohb::labelling
