// Fits what labelling learns from labelled people (dataset/labelling/label_model.h). The person of a scan is
// its name up to the first "_", so that all forms of one person are in one fold; and whoever wears one of the
// person's garments is left out with the person.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "dataset/labelling/labeller.h"
#include "tests/bench/robot_run.h"

namespace ohb {
using namespace labelling;
using namespace surface;

/// One scan, with what fitting needs of it.
struct FitHuman {
  const RobotHuman* human = nullptr;
  std::string person;
  std::set<std::string> garments;  // names of the assets worn, by the scan's JSON (or x.parts.json)
  bool is_generated = false;       // by `openhumanbrdf people`: its JSON has a recipe
  double unit_cm = 1;
  FaceFeatures features;
  std::vector<Cues> cues;
};
FitHuman prepare_fit(const RobotHuman& human);

/// A label's lead, its share of the person's area, its part (skin, hair, garment) and whether that is right.
struct LeadSample {
  float lead = 0, weight = 0;
  bool is_right = false;
  int part = kGarment;
};

/// Softmax of the parts by Newton's method, people that were generated and others each half of the
/// weight, with a ridge that keeps cues that
/// separate the people fully within reason.
void fit_parts(const std::vector<const FitHuman*>& humans, LabelModel& model);
/// A piece, and the shares of its area by class. Leather is told from fabric against how common it is among
/// the people of the piece's kind: those of `openhumanbrdf people` wear far more than others.
struct PieceSample {
  Garment piece;
  PieceCues cues;
  std::array<double, kClassCount> share{};
  double weight = 0;
  bool is_generated = false;
};
/// Logistic regressions with a ridge; a piece counts by the root of its area.
PieceWeights fit_pieces(const std::vector<PieceSample>& samples);
/// Of each part the share that is right by the lead: a logistic regression, as knots a unit apart.
void fit_calibration(const std::vector<LeadSample>& samples, LabelModel& model);

/// The model of each scan, fitted without its person and without those who share a garment. Generated people
/// share garments with nearly all others: they are taught by the other half of them, and are here to teach.
std::vector<LabelModel> cross_validated_models(const std::vector<FitHuman>& humans, LabelModel& of_all);

}  // namespace ohb
