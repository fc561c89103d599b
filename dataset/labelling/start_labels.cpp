#include "dataset/labelling/start_labels.h"

#include <algorithm>
#include <cmath>

namespace ohb::labelling {
namespace {

constexpr float kLeast = 0.01f;  // no start label is surer than the walk may overrule

}  // namespace

float trust_in(const ClassValues& probability) {
  float entropy = 0;
  for (float p : probability) entropy -= p > 0 ? p * std::log(p) : 0;
  return 1 - entropy / std::log(static_cast<float>(kClassCount));
}

StartLabels start_labels(const FaceFeatures& features, const LabelModel& model) {
  StartCues found = start_cues(features);
  StartLabels start;
  start.frame = found.frame;
  start.found_face = found.found_face;
  for (const Cues& cues : found.cues) {
    const PartValues part = part_probability(model, cues);
    ClassValues p = {part[kSkin], part[kHair], part[kGarment], 0};
    float sum = 0;
    for (int c = 0; c <= kFabric; ++c) sum += p[c] = std::max(p[c], kLeast);
    for (float& value : p) value /= sum;
    start.probability.push_back(p);
    start.trust.push_back(trust_in(p));
  }
  return start;
}

}  // namespace ohb::labelling
