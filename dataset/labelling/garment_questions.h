// What strokes say of garments as a whole, and what only the user can tell.
#pragma once

#include <string>
#include <vector>

#include "dataset/labelling/alpha_expansion.h"
#include "dataset/labelling/garments.h"
#include "dataset/labelling/strokes.h"

namespace ohb::labelling {

/// A garment (or skin or hair that may be one) whose class is a guess: "trousers, 9581 cm2: fabric or
/// leather?"
struct GarmentQuestion {
  std::string name;  // of the garment: short, and the same whatever else is answered
  size_t garment = 0;
  uint8_t now = kFabric, rival = kLeather;  // its likeliest class, and the next
  float probability = 0;                    // of `now`
  double area_cm2 = 0;
  uint32_t face = 0;  // in its middle: a stroke there answers for the whole garment
};
constexpr size_t kMostQuestions = 5;

/// Sets the garments that strokes tell. A stroke speaks for the whole garment if it covers its middle, or if
/// (chance of its class for this garment) x (likeness of its place with the garment) is above that of an
/// exception; of several classes the one with more votes holds, a small stroke's being less, the first if
/// equal. A small garment that none tells is of the class of the told one that looks like it.
void hear_strokes(const FaceFeatures& features, double unit_cm, const Garments& garments,
                  std::vector<Stroke> strokes, std::vector<ClassValues>& classes);

/// Those worth asking: where the answer may be expected to mend at least kWorthAsking of the area, or a guess
/// holds for more than kLargeGuess of it; the kMostQuestions that are worth most, the largest garment first.
std::vector<GarmentQuestion> open_questions(const Garments& garments,
                                            const std::vector<ClassValues>& classes);
/// Where the odds are near even the labels of the faces decide what a garment is now.
void say_as_labelled(const FaceGraph& graph, const Garments& garments,
                     const std::vector<ClassValues>& classes, const std::vector<uint8_t>& face_class,
                     std::vector<GarmentQuestion>& questions);
/// Whether a stroke named a garment's class, by the class's probability.
bool is_told(float probability);
constexpr float kWorthAsking = 0.01f, kLargeGuess = 0.06f;
bool is_asked(const std::vector<GarmentQuestion>& questions, uint32_t garment);

}  // namespace ohb::labelling
