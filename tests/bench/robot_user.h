// A user made of rules: paints the next stroke where the labels are most wrong.
#pragma once

#include <random>
#include <vector>

#include "dataset/labelling/strokes.h"

namespace ohb {
using namespace labelling;

struct RobotNoise {
  double jitter_cm = 0;    // of each point of a stroke: uniform in a cube of twice that edge
  double wrong_share = 0;  // of the strokes that name another class
};

/// The next stroke: in the connected region of wrongly labelled faces of one true class that has the largest
/// area, through the face farthest from its border, up to 6 cm long and as broad as the region allows.
/// No points if every face is right.
Stroke next_stroke(const FaceGraph& graph, double unit_cm, const std::vector<uint8_t>& face_class,
                   const std::vector<uint8_t>& truth, const RobotNoise& noise, std::mt19937& random);

/// The class of the stroke that is nearest along the surface: what a user could do without any of this. Faces
/// that no stroke reaches keep `otherwise`.
std::vector<uint8_t> nearest_stroke_classes(const FaceGraph& graph, double unit_cm,
                                            const std::vector<Stroke>& strokes,
                                            const std::vector<uint8_t>& otherwise);

}  // namespace ohb
