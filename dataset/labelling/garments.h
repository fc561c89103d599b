// The garments of a scan: pieces of the surface of one look, told apart by colour, creases and place, also on
// one closed surface. Whether one is fabric or leather holds for the whole of it, and colour cannot say. So
// are pieces of bare skin and of hair, which may be garments of that colour; on the head all but the face.
#pragma once

#include <string>
#include <vector>

#include "dataset/labelling/start_cues.h"

namespace ohb::labelling {

struct Garment {
  std::string name;  // "trousers"; with "-2" where there are two of that name, the largest first
  float area_cm2 = 0;
  uint32_t face = 0;  // in the middle of its largest connected part
  Appearance look = Appearance::Zero();
  float variation = 0;  // mean look_difference of its faces
  bool is_shoe = false, is_on_head = false;
  uint8_t part = kFabric;  // what it was found as: kSkin, kHair, or kFabric for a garment
};

struct Garments {
  static constexpr uint32_t kNone = 0xffffffffu;
  std::vector<Garment> garments;  // largest first
  double all_cm2 = 0;             // of the whole scan
  std::vector<uint32_t>
      of_face;  // index of each face's garment; kNone for the face and crumbs of skin and hair
};

/// `part`: of each face kSkin, kHair or kFabric (a garment). Faces of one part are merged to regions while
///   A B / (A + B) |difference of the looks|^2 / (length of their common border) < kSeparate_cm
/// (Koepfler, Lopez and Morel, "A multiscale algorithm for image segmentation by variational method", SIAM J.
/// Numer. Anal. 1994), looks in units of kLookWidth, the border shorter along creases and edges of colour;
/// crumbs go to the neighbour that is most like them; then both shoes, both legs and what else lies at one
/// height and looks alike is one garment, and faces of small ones that look like a large one are its. Skin
/// and hair on the head are pieces of their own, without the skin that holds the face.
Garments find_garments(const FaceFeatures& features, const std::vector<float>& likeness,
                       const BodyFrame& frame, const std::vector<uint8_t>& part);
constexpr float kSeparate_cm = 1.75f, kSeparateSkin_cm = 1.5f;  // of garments; of skin and hair
constexpr float kAlike = 4;  // look_difference of parts of one garment that do not touch

/// The face that most rings of faces separate from the outside of these connected faces.
uint32_t middle_of(const FaceGraph& graph, const std::vector<uint32_t>& faces);

/// |difference of two looks|^2 in units of what one garment varies.
float look_difference(const Appearance& l, const Appearance& r);

}  // namespace ohb::labelling
