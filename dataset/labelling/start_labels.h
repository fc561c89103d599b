// Start labels without any stroke: how likely each face is skin, hair, fabric or leather, from the place on
// the body, the colour and the texture.
#pragma once

#include <vector>

#include "dataset/labelling/face_features.h"

namespace ohb {

/// Where the parts of the body are, in cm in the scan's axes (Y up, facing +Z).
struct BodyFrame {
  bool is_whole = true;  // a person from head to foot; else a head or a bust
  float ground_cm = 0, top_cm = 0;
  float chin_cm = 0, eyes_cm = 0;      // heights
  float head_x_cm = 0, head_z_cm = 0;  // the head's vertical axis
  float head_cm = 23;                  // from chin to top
};
BodyFrame body_frame(const FaceGraph& graph);

struct StartLabels {
  BodyFrame frame;
  bool found_face = false;               // skin where the face should be; without, no skin is known
  std::vector<ClassValues> probability;  // sums to 1
  std::vector<float> trust;              // in [0,1]: how much of it is known
};
StartLabels start_labels(const FaceFeatures& features);

}  // namespace ohb
