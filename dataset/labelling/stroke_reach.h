// What a stroke says beyond the faces that it covers: the garment that it lies on, not the dot alone.
#pragma once

#include <vector>

#include "dataset/labelling/face_features.h"
#include "dataset/labelling/strokes.h"

namespace ohb::labelling {

/// How much a face is like the faces of a stroke, in (0, 1].
struct StrokeLikeness {
  uint32_t face;
  float value;
};

/// The faces that look as those of a stroke do and that a way over such faces, of the same start class,
/// connects with it: Gaussian of the difference in appearance, times exp(-way / kStrokeReach_cm); a way is
/// longer where neighbours differ. Values below 0.01 are left out. In the order of the faces.
std::vector<StrokeLikeness> reach_of_stroke(const FaceFeatures& features, const std::vector<float>& likeness,
                                            const std::vector<uint8_t>& start_class,
                                            const std::vector<uint32_t>& stroke_faces);
constexpr float kStrokeReach_cm = 40;

}  // namespace ohb::labelling
