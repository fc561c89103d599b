#include "tests/bench/label_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "dataset/model/scan_unit.h"

namespace ohb {
using namespace labelling;
using namespace surface;
namespace {

constexpr size_t kSampledFaces = 6000;  // of a scan
constexpr double kPartRidge = 3e-4;     // against a mean log likelihood
constexpr int kNewtonSteps = 12;
int part_of(uint8_t material_class) {
  return std::min<int>(material_class, kGarment);
}

/// Negative mean log likelihood's gradient and Hessian over the weights of skin and hair.
struct Newton {
  static constexpr int kSize = (kPartCount - 1) * kCueCount;
  Eigen::Matrix<double, kSize, 1> gradient = Eigen::Matrix<double, kSize, 1>::Zero();
  Eigen::Matrix<double, kSize, kSize> hessian = Eigen::Matrix<double, kSize, kSize>::Zero();

  void add(const Cues& cues, const PartValues& p, int part, double weight) {
    Eigen::Matrix<double, kCueCount, 1> x;
    for (int i = 0; i < kCueCount; ++i) x[i] = cues[i];
    for (int k = 0; k < kGarment; ++k) {
      gradient.segment<kCueCount>(k * kCueCount) += weight * (p[k] - (part == k)) * x;
      for (int l = 0; l < kGarment; ++l)
        hessian.block<kCueCount, kCueCount>(k * kCueCount, l * kCueCount) +=
            weight * p[k] * ((k == l) - p[l]) * (x * x.transpose());
    }
  }
};

}  // namespace

FitHuman prepare_fit(const RobotHuman& human) {
  FitHuman fit;
  fit.human = &human;
  fit.person = human.name.substr(0, human.name.find('_'));
  fit.unit_cm = guess_unit(human.scan).unit_cm.value_or(1);
  fit.features = face_features(human.scan, fit.unit_cm);
  fit.cues = start_cues(fit.features).cues;
  return fit;
}

void fit_parts(const std::vector<const FitHuman*>& humans, LabelModel& model) {
  model.part_weights = {};
  for (int step = 0; step < kNewtonSteps; ++step) {
    Newton newton;
    for (const FitHuman* human : humans) {
      const std::vector<float>& area = human->features.graph.area_cm2;
      const size_t stride = std::max<size_t>(1, area.size() / kSampledFaces);
      double total = 0;
      for (size_t f = 0; f < area.size(); f += stride) total += area[f];
      for (size_t f = 0; f < area.size(); f += stride)
        if (human->human->truth[f] < kClassCount)
          newton.add(human->cues[f], part_probability(model, human->cues[f]), part_of(human->human->truth[f]),
                     area[f] / total / static_cast<double>(humans.size()));
    }
    for (int i = 0; i < Newton::kSize; ++i) {
      newton.gradient[i] += kPartRidge * model.part_weights[i / kCueCount][i % kCueCount];
      newton.hessian(i, i) += kPartRidge;
    }
    const Eigen::VectorXd move = newton.hessian.ldlt().solve(newton.gradient);
    const double length = std::min(1.0, 8 / (move.cwiseAbs().maxCoeff() + 1e-9));
    for (int i = 0; i < Newton::kSize; ++i)
      model.part_weights[i / kCueCount][i % kCueCount] -= static_cast<float>(length * move[i]);
  }
}

void fit_calibration(std::vector<LeadSample> samples, LabelModel& model) {
  constexpr double kLeastBlock = 0.004, kCounts = 0.0005;
  std::sort(samples.begin(), samples.end(), [](const auto& l, const auto& r) { return l.lead < r.lead; });
  double total = 0;
  for (const LeadSample& sample : samples) total += sample.weight;
  struct Block {
    double weight = 0, lead = 0, right = 0;
    double share() const { return (right + 0.5 * kCounts) / (weight + kCounts); }
  };
  std::vector<Block> blocks(1);
  for (const LeadSample& sample : samples) {
    if (blocks.back().weight > kLeastBlock * total) blocks.emplace_back();
    blocks.back().weight += sample.weight;
    blocks.back().lead += sample.weight * sample.lead;
    blocks.back().right += sample.weight * sample.is_right;
  }
  std::vector<Block> rising;
  for (Block block : blocks) {
    const auto is_short = [&](const Block& before) {  // falls, or too close to need a knot
      return before.share() >= block.share() || block.lead / block.weight - before.lead / before.weight < 0.3;
    };
    while (!rising.empty() && is_short(rising.back())) {
      block.weight += rising.back().weight;
      block.lead += rising.back().lead;
      block.right += rising.back().right;
      rising.pop_back();
    }
    rising.push_back(block);
  }
  model.lead.clear();
  model.right.clear();
  for (const Block& block : rising) {
    model.lead.push_back(static_cast<float>(block.lead / block.weight));
    model.right.push_back(static_cast<float>(block.share()));
  }
}

std::vector<LabelModel> cross_validated_models(const std::vector<FitHuman>& humans, LabelModel& of_all) {
  std::set<std::string> people;
  for (const FitHuman& human : humans) people.insert(human.person);
  std::vector<LabelModel> models(humans.size());
  std::vector<std::vector<LeadSample>> leads(humans.size());
  const auto others = [&](const std::string& person, const auto& add) {
    for (size_t i = 0; i < humans.size(); ++i)
      if (humans[i].person != person) add(i);
  };
  const auto finish = [&](const std::string& left_out, LabelModel& model) {
    std::vector<LeadSample> lead;
    others(left_out, [&](size_t i) { lead.insert(lead.end(), leads[i].begin(), leads[i].end()); });
    fit_calibration(lead, model);
  };
  for (const std::string& person : people) {
    std::vector<const FitHuman*> training;
    others(person, [&](size_t i) { training.push_back(&humans[i]); });
    LabelModel model;
    fit_parts(training, model);
    for (size_t i = 0; i < humans.size(); ++i) {
      if (humans[i].person != person) continue;
      models[i] = model;
      Labeller labeller(humans[i].features, humans[i].unit_cm, model);
      const Labelling labels = labeller.solve({});
      double all = 0;
      for (double area : humans[i].human->area) all += area;
      for (size_t f = 0; f < labels.lead.size(); ++f)
        if (humans[i].human->truth[f] < kClassCount)
          leads[i].push_back({labels.lead[f], static_cast<float>(humans[i].human->area[f] / all),
                              part_of(labels.face_class[f]) == part_of(humans[i].human->truth[f])});
    }
  }
  for (size_t i = 0; i < humans.size(); ++i) finish(humans[i].person, models[i]);
  std::vector<const FitHuman*> training;
  others("", [&](size_t i) { training.push_back(&humans[i]); });
  fit_parts(training, of_all);
  finish("", of_all);
  return models;
}

}  // namespace ohb
