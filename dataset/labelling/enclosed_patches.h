// Small patches that are of another part or class than all that surrounds them, and should not be: palms and
// lips amid skin, soles of the colour of skin under shoes, bits of a garment.
#pragma once

#include <vector>

#include "dataset/labelling/start_cues.h"

namespace ohb::labelling {

struct PartChange {
  uint32_t face;
  uint8_t part;  // kSkin, or kFabric for a garment
};

/// `part`: of each face kSkin, kHair or kFabric (a garment). A connected patch of cloth below 1 % of the area
/// that is surrounded by skin and has its hue is skin (a palm of a dark hand); one of skin that is surrounded
/// by cloth, lower than the middle of a bare foot, is a sole.
std::vector<PartChange> enclosed_patches(const FaceFeatures& features, const BodyFrame& frame,
                                         const std::vector<uint8_t>& part);

struct LabelChange {
  uint32_t face;
  uint8_t material_class;
};

/// `face_class`: of each face. A connected patch of fabric, leather or hair below 1 % of the area, of which
/// no face is told, takes the class of the fabric or leather that surrounds it (bits of hair and of other
/// cloth on a garment are rarer than mistakes).
std::vector<LabelChange> enclosed_labels(const FaceFeatures& features, const std::vector<uint8_t>& face_class,
                                         const std::vector<bool>& is_told);

}  // namespace ohb::labelling
