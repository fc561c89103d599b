#include "dataset/labelling/labeller.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "dataset/labelling/class_pairs.h"
#include "dataset/labelling/enclosed_patches.h"

namespace ohb::labelling {
namespace {

constexpr float kColour = 0.5f, kWalk = 1, kBorder_cm = 1.5f;
/// How far a walk goes where the start labels are sure; three times as far where they know nothing.
constexpr float kReach_cm = 3;
constexpr float kLeastTrust = 0.1f;
constexpr float kSeed = 50;          // conductance of a stroked face: far more than all its borders
constexpr float kFloor = 0.01f;      // least probability: no term decides alone
constexpr float kStrokeCost = 1e7f;  // of another class than the stroke's
constexpr size_t kColourSamples = 6000;
constexpr float kTelling_cm2 = 6;  // a stroke on less is a correction and tells less of look-alikes
/// A user paints first what is most wrong, so what n strokes left alone is likely right: the next one speaks
/// for less of what is far or looks otherwise, its likeness raised to 1 + kSharpening n.
constexpr float kSharpening = 0.3f;
constexpr size_t kMostSharpened = 10;
constexpr float kStrokeShare = 4;   // what looks like a stroke against the start labels
constexpr float kSureShare = 0.5f;  // faces below are not what their class looks like

/// What garment a crumb is of is not known.
constexpr ClassValues kElsewhere = {0, 0, 0.9f, 0.1f};

LabelModel model_with(float leather_share) {
  LabelModel model = installed_label_model();
  model.leather_share = leather_share;
  return model;
}

}  // namespace

Labeller::Labeller(const ScanSurface& surface, LabelTerms terms, float leather_share)
    : Labeller(face_features(surface), surface.unit_cm, model_with(leather_share), terms) {}

Labeller::Labeller(FaceFeatures features, double unit_cm, LabelModel model, LabelTerms terms)
    : unit_cm_(unit_cm),
      terms_(terms),
      model_(std::move(model)),
      features_(std::move(features)),
      start_(start_labels(features_, model_)),
      likeness_(edge_likeness(features_)) {
  const FaceGraph& graph = features_.graph;
  std::vector<EnergyPair> conductance;
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const FaceEdge& edge = graph.edges[e];
    conductance.push_back({edge.a, edge.b, likeness_[e] * edge.length_cm / edge.distance_cm});
    borders_.push_back(
        {edge.a, edge.b, kBorder_cm * edge.length_cm * (terms.likeness ? likeness_[e] : 1.0f)});
  }
  std::vector<float> restart;
  for (size_t f = 0; f < graph.size(); ++f)
    restart.push_back((graph.area_cm2[f] + 1e-6f) * (kLeastTrust + start_.trust[f]) /
                      (kReach_cm * kReach_cm));
  walker_.emplace(graph.size(), conductance, std::move(restart));
  find_parts();
}

void Labeller::find_parts() {
  const std::vector<ClassValues> walk = walker_->solve(start_.probability, {});
  const LabelEnergy energy = energy_of_faces(walk, {});
  std::vector<uint8_t> part;
  for (const ClassValues& cost : energy.cost)
    part.push_back(static_cast<uint8_t>(std::min_element(cost.begin(), cost.end()) - cost.begin()));
  minimise(energy, part);
  take_patches_for_what_surrounds_them(part);
  garments_ = find_garments(features_, likeness_, start_.frame, part);
  piece_cues_ = labelling::piece_cues(features_, garments_, start_.frame, part);
  for (size_t g = 0; g < piece_cues_.size(); ++g)
    garment_classes_.push_back(
        piece_classes(garments_.garments[g], piece_cues_[g], model_.pieces, model_.leather_share));
  for (const ClassValues& p : start_of_faces(garment_classes_))
    start_class_.push_back(static_cast<uint8_t>(std::max_element(p.begin(), p.end()) - p.begin()));
}

void Labeller::take_patches_for_what_surrounds_them(std::vector<uint8_t>& part) {
  constexpr float kLikely = 0.85f;
  for (const PartChange& change : enclosed_patches(features_, start_.frame, part)) {
    part[change.face] = change.part;
    ClassValues& start = start_.probability[change.face];
    start = {1 - kLikely, 0, 1 - kLikely, 0};
    start[change.part] = kLikely;
  }
}

std::vector<ClassValues> Labeller::start_of_faces(const std::vector<ClassValues>& classes) const {
  std::vector<ClassValues> start = start_.probability;
  for (size_t f = 0; f < start.size(); ++f) {
    const uint32_t g = garments_.of_face[f];
    const uint8_t own = g == Garments::kNone ? uint8_t{kFabric} : garments_.garments[g].part;
    const ClassValues made_of = g == Garments::kNone ? kElsewhere : classes[g];
    const float share = start[f][own];
    start[f][own] = 0;
    for (int c = 0; c < kClassCount; ++c) start[f][c] += share * made_of[c];
  }
  return start;
}

/// The faces that strokes name, and those of a garment that was told what it is, of that class.
std::vector<bool> Labeller::told_faces(const std::vector<ClassValues>& classes,
                                       const StrokedFaces& stroked) const {
  std::vector<bool> told(features_.size(), false);
  for (size_t f = 0; f < told.size(); ++f) {
    const uint32_t g = garments_.of_face[f];
    told[f] = g != Garments::kNone && is_told(classes[g][face_class_[f]]);
  }
  for (uint32_t f : stroked.face) told[f] = true;
  return told;
}

/// A face is right if its piece is what it is said to be, and the face is of the piece, by its own costs.
void Labeller::trust_garments(const std::vector<ClassValues>& classes, Labelling& labels) const {
  for (size_t f = 0; f < labels.confidence.size(); ++f) {
    const uint8_t c = labels.face_class[f];
    const uint32_t g = garments_.of_face[f];
    const ClassValues& of = g == Garments::kNone ? kElsewhere : classes[g];
    const float garment = std::accumulate(of.begin() + kFabric, of.end(), 0.0f);
    const float claim = c < kFabric ? of[c] : garment;
    if (claim > 0.5f && g != Garments::kNone) labels.confidence[f] *= claim;
    if (c >= kFabric) labels.confidence[f] *= of[c] / std::max(garment, 1e-6f);
  }
}

std::vector<float> Labeller::reach_weights() const {
  std::vector<float> area_cm2, weight;
  for (const Reach& reach : reaches_) {
    area_cm2.push_back(0);
    for (uint32_t f : reach.covered) area_cm2.back() += features_.graph.area_cm2[f];
    weight.push_back(std::min(1.0f, area_cm2.back() / kTelling_cm2));
  }
  std::vector<ClassValues> votes(features_.size(), ClassValues{});
  for (size_t s = 0; s < reaches_.size(); ++s)
    for (const StrokeLikeness& like : reaches_[s].faces)
      votes[like.face][reaches_[s].stroke.material_class] += weight[s] * like.value;
  for (size_t s = 0; s < reaches_.size(); ++s) {
    float share = 0;
    for (uint32_t f : reaches_[s].covered) {
      const float all = std::accumulate(votes[f].begin(), votes[f].end(), 0.0f);
      if (all > 0) share += features_.graph.area_cm2[f] * votes[f][reaches_[s].stroke.material_class] / all;
    }
    weight[s] *= area_cm2[s] > 0 ? share / area_cm2[s] : 0;
  }
  return weight;
}

std::vector<ClassValues> Labeller::revised_start(const std::vector<ClassValues>& first,
                                                 const std::vector<Stroke>& strokes) {
  const auto is_same = [](const Stroke& l, const Stroke& r) {
    return l.radius_cm == r.radius_cm && l.points.size() == r.points.size() &&
           std::equal(l.points.begin(), l.points.end(), r.points.begin(), [](const auto& p, const auto& q) {
             return p.face == q.face && p.at.x == q.at.x && p.at.y == q.at.y && p.at.z == q.at.z;
           });
  };
  std::vector<size_t> order(strokes.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t l, size_t r) { return strokes[l].time_s < strokes[r].time_s; });
  reaches_.resize(strokes.size());
  tbb::parallel_for(size_t{0}, strokes.size(), [&](size_t rank) {
    const size_t s = order[rank];
    Reach& reach = reaches_[s];
    const float sharpness = 1 + kSharpening * static_cast<float>(std::min(rank, kMostSharpened));
    if (is_same(reach.stroke, strokes[s]) && reach.sharpness == sharpness) {
      reach.stroke.material_class = strokes[s].material_class;
      return;
    }
    std::vector<uint32_t> covered = faces_of_stroke(strokes[s], features_.graph, unit_cm_);
    std::vector<StrokeLikeness> reached = reach_of_stroke(features_, likeness_, start_class_, covered);
    for (StrokeLikeness& like : reached) like.value = std::pow(like.value, sharpness);
    reach = {strokes[s], sharpness, std::move(covered), std::move(reached)};
  });
  const std::vector<float> weight = reach_weights();
  std::vector<ClassValues> best(features_.size(), ClassValues{});
  for (size_t s = 0; s < strokes.size(); ++s)
    for (const StrokeLikeness& like : reaches_[s].faces) {
      float& value = best[like.face][strokes[s].material_class];
      value = std::max(value, weight[s] * like.value);
    }
  std::vector<ClassValues> start = first;
  for (size_t f = 0; f < start.size(); ++f) {
    const float sum = std::accumulate(best[f].begin(), best[f].end(), 0.0f);
    for (int c = 0; c < kClassCount; ++c)
      start[f][c] = (start[f][c] + kStrokeShare * best[f][c]) / (1 + kStrokeShare * sum);
  }
  return start;
}

std::vector<ClassValues> Labeller::colour_probability(const std::vector<ClassValues>& share,
                                                      const StrokedFaces& stroked) const {
  const size_t faces = share.size();
  std::vector<uint32_t> sample = stroked.face;
  for (size_t f = 0; f < faces; f += std::max<size_t>(1, faces / kColourSamples))
    sample.push_back(static_cast<uint32_t>(f));
  std::vector<Appearance> looks;
  looks.reserve(sample.size());
  for (uint32_t f : sample) looks.push_back(features_.appearance[f]);
  std::array<std::optional<ColourModel>, kClassCount> models;
  tbb::parallel_for(0, kClassCount, [&](int c) {
    std::vector<float> weights;
    weights.reserve(sample.size());
    for (uint32_t f : sample)
      weights.push_back(share[f][c] > kSureShare ? features_.graph.area_cm2[f] * share[f][c] * share[f][c]
                                                 : 0);
    models[c].emplace(looks, weights);
  });
  std::vector<ClassValues> probability(faces);
  tbb::parallel_for(size_t{0}, faces, [&](size_t f) {
    ClassValues& p = probability[f];
    for (int c = 0; c < kClassCount; ++c) p[c] = models[c]->log_density(features_.appearance[f]);
    const float highest = *std::max_element(p.begin(), p.end());
    float sum = 0;
    for (float& value : p) sum += value = std::exp(value - highest);
    for (float& value : p) value /= sum;
  });
  return probability;
}

LabelEnergy Labeller::energy_of_faces(const std::vector<ClassValues>& walk,
                                      const StrokedFaces& stroked) const {
  LabelEnergy energy;
  energy.distance = kClassDistance;
  if (terms_.border) energy.pairs = borders_;
  energy.cost.resize(features_.size());
  std::vector<ClassValues> colour;
  if (terms_.colour) colour = colour_probability(walk, stroked);
  for (size_t f = 0; f < energy.cost.size(); ++f)
    for (int c = 0; c < kClassCount; ++c) {
      float cost = 0;
      if (terms_.colour) cost -= kColour * std::log(colour[f][c] + kFloor);
      if (terms_.prior) cost -= kWalk * std::log(walk[f][c] + kFloor);
      energy.cost[f][c] = features_.graph.area_cm2[f] * cost;
    }
  for (size_t i = 0; i < stroked.face.size(); ++i)
    for (int c = 0; c < kClassCount; ++c)
      if (c != stroked.material_class[i]) energy.cost[stroked.face[i]][c] += kStrokeCost;
  return energy;
}

Labelling Labeller::solve(const std::vector<Stroke>& strokes) {
  const StrokedFaces stroked = stroked_faces(strokes, features_.graph, unit_cm_);
  std::vector<Seed> seeds;
  for (size_t i = 0; i < stroked.face.size(); ++i)
    seeds.push_back({stroked.face[i], stroked.material_class[i], kSeed});
  std::vector<ClassValues> classes = garment_classes_;
  hear_strokes(features_, unit_cm_, garments_, strokes, classes);
  const std::vector<ClassValues> first = start_of_faces(classes);
  const std::vector<ClassValues> start = terms_.reach ? revised_start(first, strokes) : first;
  walk_ = terms_.walk ? walker_->solve(start, seeds, walk_) : start;
  const LabelEnergy energy = energy_of_faces(walk_, stroked);
  if (face_class_.empty())
    for (const ClassValues& cost : energy.cost)
      face_class_.push_back(static_cast<uint8_t>(std::min_element(cost.begin(), cost.end()) - cost.begin()));
  minimise(energy, face_class_, strokes.empty() ? uint8_t{kSkin} : uint8_t{strokes.back().material_class});
  const std::vector<uint8_t> least = face_class_;  // where the next call starts
  for (const LabelChange& change : enclosed_labels(features_, face_class_, told_faces(classes, stroked)))
    face_class_[change.face] = change.material_class;
  Labelling result;
  result.face_class = face_class_;
  result.lead = leads_of(energy, features_.graph.area_cm2, face_class_);
  for (size_t f = 0; f < result.lead.size(); ++f)
    result.confidence.push_back(
        calibrated(model_.calibration[std::min<int>(face_class_[f], kGarment)], result.lead[f]));
  trust_garments(classes, result);
  for (uint32_t f : stroked.face) result.confidence[f] = 1;
  result.questions = open_questions(garments_, classes);
  say_as_labelled(features_.graph, garments_, classes, face_class_, result.questions);
  for (size_t f = 0; f < features_.size(); ++f)
    result.is_in_doubt.push_back(result.confidence[f] < kDoubtful ||
                                 is_asked(result.questions, garments_.of_face[f]));
  for (uint32_t f : stroked.face) result.is_in_doubt[f] = false;
  result.suggested = suggest_stroke(features_.graph, energy, face_class_, result.confidence);
  face_class_ = least;
  result.warnings = stroked.warnings;
  return result;
}

Stroke stroke_of_answer(const Labeller& labeller, size_t garment, MaterialClass material_class) {
  const uint32_t face = labeller.garments().garments[garment].face;
  Stroke stroke;
  stroke.material_class = material_class;
  stroke.points = {
      {face, labeller.features().graph.centre_cm[face] / static_cast<float>(labeller.unit_cm())}};
  return stroke;
}

}  // namespace ohb::labelling
