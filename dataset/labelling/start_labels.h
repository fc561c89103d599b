// Start labels without any stroke: how likely each face is skin, hair or a garment, from its cues.
#pragma once

#include <vector>

#include "dataset/labelling/label_model.h"
#include "dataset/labelling/start_cues.h"

namespace ohb::labelling {

struct StartLabels {
  BodyFrame frame;
  bool found_face = false;  // skin where the face should be; without, no skin is known
  /// Sums to 1; what a garment may be made of is not known yet: all of it is fabric.
  std::vector<ClassValues> probability;
  std::vector<float> trust;  // in [0,1]: how much of it is known
};
StartLabels start_labels(const FaceFeatures& features, const LabelModel& model);

/// How much the probabilities of one face leave open: 1 less their entropy over that of knowing nothing.
float trust_in(const ClassValues& probability);

}  // namespace ohb::labelling
