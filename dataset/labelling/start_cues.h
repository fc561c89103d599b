// What start labels go by: for each face a few numbers from the place on the body, the person's own colours
// and the texture. How much each counts is fitted, see label_model.h.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "dataset/labelling/face_features.h"

namespace ohb::labelling {

/// Where the parts of the body are, in cm in the scan's axes (Y up, facing +Z).
struct BodyFrame {
  bool is_whole = true;  // a person from head to foot; else a head or a bust
  float ground_cm = 0, top_cm = 0;
  float chin_cm = 0, eyes_cm = 0;      // heights
  float head_x_cm = 0, head_z_cm = 0;  // the head's vertical axis
  float head_cm = 23;                  // from chin to top
  Vec3f front = {0, 0, 1};             // where the face looks, horizontal, of length 1

  /// Height above the ground as a share of the person's.
  float share_of(float y_cm) const { return (y_cm - ground_cm) / (top_cm - ground_cm); }
  /// How far a point lies before the head's axis, and how far beside it.
  float before_axis_cm(Vec3f at) const { return (at.x - head_x_cm) * front.x + (at.z - head_z_cm) * front.z; }
  float beside_axis_cm(Vec3f at) const {
    return std::abs((at.x - head_x_cm) * front.z - (at.z - head_z_cm) * front.x);
  }
};
/// The front is +Z unless what lies there has mostly the crown's colour, and skin lies at another side.
BodyFrame body_frame(const FaceFeatures& features);
/// Whether a mesh's face lies where the front of the person's face is, between chin and eyes.
bool is_face_front(const FaceGraph& graph, const BodyFrame& frame, uint32_t face);

constexpr int kCueCount = 14;
using Cues = std::array<float, kCueCount>;
/// In the order of Cues; the weights are stored by these names.
constexpr std::array<const char*, kCueCount> kCueNames = {"one",
                                                          "skin_distance",
                                                          "skin_distance_head",
                                                          "hair_distance",
                                                          "hair_distance_head",
                                                          "hair_joined",
                                                          "hair_joined_low",
                                                          "head",
                                                          "face",
                                                          "above_eyes",
                                                          "foot",
                                                          "texture",
                                                          "skin_near",
                                                          "hair_near"};

struct StartCues {
  BodyFrame frame;
  bool found_face = false;  // skin where the face should be; without, no skin is known
  std::vector<Cues> cues;   // each within about [-1, 3]
};
StartCues start_cues(const FaceFeatures& features);

float hue_degrees(Vec3f lab);
float chroma(Vec3f lab);

}  // namespace ohb::labelling
