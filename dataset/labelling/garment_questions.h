// What garments may be made of, what strokes say of them as a whole, and what only the user can tell.
#pragma once

#include <string>
#include <vector>

#include "dataset/labelling/alpha_expansion.h"
#include "dataset/labelling/garments.h"
#include "dataset/labelling/strokes.h"

namespace ohb::labelling {

/// The classes of a garment whose colour cannot tell them apart: "trousers, 9581 cm2: fabric or leather?"
struct GarmentQuestion {
  std::string name;  // of the garment: short, and the same whatever else is answered
  size_t garment = 0;
  uint8_t now = kFabric, rival = kLeather;  // its likeliest class, and the next
  float probability = 0;                    // of `now`
  double area_cm2 = 0;
  uint32_t face = 0;  // in its middle: a stroke there answers for the whole garment
};
constexpr size_t kMostQuestions = 4;

/// Of each garment, before any stroke: leather or fabric by place, hair where it hangs from the hair and
/// looks like it. `part`: kSkin, kHair or kFabric (a garment) of each face.
std::vector<ClassValues> garment_classes(const FaceFeatures& features, const Garments& garments,
                                         const BodyFrame& frame, const std::vector<uint8_t>& part,
                                         const LabelModel& model);

/// Sets the garments that strokes tell: those that lie on one, look like it, and agree.
void hear_strokes(const FaceFeatures& features, double unit_cm, const Garments& garments,
                  const std::vector<Stroke>& strokes, std::vector<ClassValues>& classes);

/// Those worth asking: where the answer may be expected to mend at least kWorthAsking of the area; the
/// kMostQuestions that are worth most, the largest garment first.
std::vector<GarmentQuestion> open_questions(const Garments& garments,
                                            const std::vector<ClassValues>& classes);
constexpr float kWorthAsking = 0.0055f;

}  // namespace ohb::labelling
