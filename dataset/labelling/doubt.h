// How sure each label is, and where the next stroke would settle most.
#pragma once

#include <optional>
#include <vector>

#include "dataset/labelling/alpha_expansion.h"
#include "dataset/labelling/face_graph.h"

namespace ohb::labelling {

/// Where a stroke helps most: the face in the middle of the largest region of doubt.
struct SuggestedStroke {
  uint32_t face = 0;
  uint8_t now = kUnlabelled, rival = kUnlabelled;  // its class, and the likeliest other one
  double area_cm2 = 0;                             // of the region
};

/// Below this probability of being right a label is in doubt.
constexpr float kDoubtful = 0.8f;

/// Of each face: log odds of its own part (skin, hair, or garment: fabric and leather together) against the
/// other parts, from the faces' own costs (exp(-cost / area)), within kMostLead; below 0 where the neighbours
/// outvoted its own costs.
std::vector<float> leads_of(const LabelEnergy& energy, const std::vector<float>& area_cm2,
                            const std::vector<uint8_t>& face_class);
constexpr float kMostLead = 8;

/// The connected region of one class in doubt with the largest sum of area x (1 - confidence); nothing if no
/// face is in doubt.
std::optional<SuggestedStroke> suggest_stroke(const FaceGraph& graph, const LabelEnergy& energy,
                                              const std::vector<uint8_t>& face_class,
                                              const std::vector<float>& confidence);

}  // namespace ohb::labelling
