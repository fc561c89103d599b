#include "tests/bench/label_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <numeric>
#include <set>

#include "dataset/model/atomic_file.h"
#include "dataset/model/data_files.h"
#include "dataset/model/json_text.h"
#include "dataset/model/scan_unit.h"

namespace ohb {
using namespace labelling;
using namespace surface;
namespace {

constexpr size_t kSampledFaces = 6000;  // of a scan
constexpr double kPartRidge = 3e-4;     // against a mean log likelihood
constexpr int kNewtonSteps = 12;
/// Against a mean log likelihood: such that the slopes of the cross-validated log odds are near 1 (bare 0.9,
/// head 1.1, hanging 1.3, leather 1.0); with five times as much they were up to 2.
constexpr double kPieceRidge = 0.0004, kLeatherRidge = 0.0001, kCalibrationRidge = 1e-5;
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

/// Weights of a logistic regression on soft targets.
template <size_t N>
struct Regression {
  struct Row {
    std::array<float, N> cues;
    double target, weight;
    float odds = 0;  // log odds before any cue
  };
  std::vector<Row> rows;

  std::array<float, N> solve(double ridge = kPieceRidge) const {
    std::array<float, N> weights{};
    double total = 1e-9;
    for (const Row& row : rows) total += row.weight;
    for (int step = 0; step < kNewtonSteps; ++step) {
      Eigen::Matrix<double, N, 1> gradient = Eigen::Matrix<double, N, 1>::Zero();
      Eigen::Matrix<double, N, N> hessian = Eigen::Matrix<double, N, N>::Zero();
      for (const Row& row : rows) {
        Eigen::Matrix<double, N, 1> x;
        for (size_t i = 0; i < N; ++i) x[i] = row.cues[i];
        const double p = probability_of(weights, row.cues, row.odds), share = row.weight / total;
        gradient += share * (p - row.target) * x;
        hessian += share * p * (1 - p) * (x * x.transpose());
      }
      for (size_t i = 0; i < N; ++i) {
        gradient[i] += ridge * weights[i];
        hessian(i, i) += ridge;
      }
      const Eigen::Matrix<double, N, 1> move = hessian.ldlt().solve(gradient);
      for (size_t i = 0; i < N; ++i) weights[i] -= static_cast<float>(move[i]);
    }
    return weights;
  }
};

/// Weight of each: people that were generated and others count half each.
template <typename IsGenerated>
std::vector<double> weights_by_kind(size_t count, const IsGenerated& is_generated) {
  std::array<double, 2> counts{};
  for (size_t i = 0; i < count; ++i) ++counts[is_generated(i)];
  const double kinds = (counts[0] > 0) + (counts[1] > 0);
  std::vector<double> weights;
  for (size_t i = 0; i < count; ++i) weights.push_back(1 / (kinds * counts[is_generated(i)]));
  return weights;
}

bool tells_leather(const PieceSample& of) {
  return of.piece.part == kFabric && !of.piece.is_shoe && of.share[kFabric] + of.share[kLeather] > 0.7;
}

/// Log odds of leather among the garments of each kind of people.
std::array<float, 2> odds_of_leather(const std::vector<PieceSample>& samples) {
  std::array<double, 2> leather{0.05, 0.05}, all{1, 1};
  for (const PieceSample& of : samples) {
    if (!tells_leather(of)) continue;
    leather[of.is_generated] += of.weight * of.share[kLeather] / (of.share[kFabric] + of.share[kLeather]);
    all[of.is_generated] += of.weight;
  }
  return {log_odds(static_cast<float>(leather[0] / all[0])),
          log_odds(static_cast<float>(leather[1] / all[1]))};
}

/// The assets that the JSON beside a scan names as worn.
std::set<std::string> garments_of(const std::filesystem::path& scan, bool& is_generated) {
  std::set<std::string> garments;
  std::filesystem::path recipe = scan, parts = scan;
  recipe.replace_extension(".json");
  std::string stem = scan.stem().string();
  stem = stem.substr(0, stem.rfind('_'));
  parts.replace_filename(stem + ".parts.json");
  if (std::filesystem::exists(recipe)) {
    const nlohmann::json json = parse_json<nlohmann::json>(read_file(recipe), recipe.string());
    is_generated = json.contains("recipe");
    if (is_generated)
      for (const auto& worn : json["recipe"]["clothes"])
        garments.insert(std::filesystem::path(worn["file"].get<std::string>()).parent_path().filename());
  }
  if (std::filesystem::exists(parts)) {
    const nlohmann::json json = parse_json<nlohmann::json>(read_file(parts), parts.string());
    for (const auto& part : json["parts"])
      if (part.contains("asset")) garments.insert(part["asset"].get<std::string>());
  }
  return garments;
}

std::vector<PieceSample> piece_samples(const Labeller& labeller, const RobotHuman& human) {
  const Garments& garments = labeller.garments();
  std::vector<PieceSample> samples(garments.garments.size());
  for (size_t f = 0; f < human.truth.size(); ++f)
    if (garments.of_face[f] != Garments::kNone && human.truth[f] < kClassCount) {
      samples[garments.of_face[f]].share[human.truth[f]] += human.area[f];
      samples[garments.of_face[f]].weight += human.area[f];
    }
  double all = 0;
  for (double area : human.area) all += area;
  std::vector<PieceSample> kept;
  for (size_t g = 0; g < samples.size(); ++g) {
    if (!(samples[g].weight > 0)) continue;
    for (double& share : samples[g].share) share /= samples[g].weight;
    samples[g].weight = std::sqrt(samples[g].weight / all);
    samples[g].piece = garments.garments[g];
    samples[g].cues = labeller.piece_cues()[g];
    kept.push_back(samples[g]);
  }
  return kept;
}

}  // namespace

FitHuman prepare_fit(const RobotHuman& human) {
  FitHuman fit;
  fit.human = &human;
  fit.person = human.name.substr(0, human.name.find('_'));
  fit.garments = garments_of(human.file, fit.is_generated);
  fit.unit_cm = guess_unit(human.scan).unit_cm.value_or(1);
  fit.features = face_features({human.scan, fit.unit_cm});
  fit.cues = start_cues(fit.features).cues;
  return fit;
}

void fit_parts(const std::vector<const FitHuman*>& humans, LabelModel& model) {
  const std::vector<double> weight =
      weights_by_kind(humans.size(), [&](size_t i) { return humans[i]->is_generated; });
  model.part_weights = {};
  for (int step = 0; step < kNewtonSteps; ++step) {
    Newton newton;
    for (size_t i = 0; i < humans.size(); ++i) {
      const FitHuman* human = humans[i];
      const std::vector<float>& area = human->features.graph.area_cm2;
      const size_t stride = std::max<size_t>(1, area.size() / kSampledFaces);
      double total = 0;
      for (size_t f = 0; f < area.size(); f += stride) total += area[f];
      for (size_t f = 0; f < area.size(); f += stride)
        if (human->human->truth[f] < kClassCount)
          newton.add(human->cues[f], part_probability(model, human->cues[f]), part_of(human->human->truth[f]),
                     area[f] / total * weight[i]);
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

PieceWeights fit_pieces(const std::vector<PieceSample>& samples) {
  Regression<std::tuple_size_v<BareCues>> bare;
  Regression<std::tuple_size_v<HangingCues>> hanging;
  Regression<std::tuple_size_v<HeadCues>> head;
  Regression<std::tuple_size_v<LeatherCues>> leather;
  const std::array<float, 2> odds = odds_of_leather(samples);
  for (const PieceSample& of : samples) {
    const double garment = of.share[kFabric] + of.share[kLeather], rest = garment + of.share[kHair];
    if (of.piece.part == kSkin) bare.rows.push_back({of.cues.bare, of.share[kSkin], of.weight});
    if (of.piece.is_on_head && rest > 0.5)
      head.rows.push_back({of.cues.head, of.share[kHair] / rest, of.weight});
    else if (of.cues.may_be_hair && rest > 0.5)
      hanging.rows.push_back({of.cues.hanging, of.share[kHair] / rest, of.weight});
    if (tells_leather(of))
      leather.rows.push_back(
          {of.cues.leather, of.share[kLeather] / garment, of.weight, odds[of.is_generated]});
  }
  return {bare.solve(), hanging.solve(), head.solve(), leather.solve(kLeatherRidge)};
}

void fit_calibration(const std::vector<LeadSample>& samples, LabelModel& model) {
  constexpr int kSteps = 320;  // of the leads
  for (int k = 0; k < kPartCount; ++k) {
    std::array<double, kSteps + 1> weight{}, right{};
    for (const LeadSample& sample : samples) {
      if (sample.part != k) continue;
      const auto step = std::lround((sample.lead + kMostLead) / (2 * kMostLead) * kSteps);
      weight[step] += sample.weight;
      right[step] += sample.weight * sample.is_right;
    }
    Regression<2> fit;
    for (int step = 0; step <= kSteps; ++step)
      if (weight[step] > 0)
        fit.rows.push_back({{1, kMostLead * (2.0f * static_cast<float>(step) / kSteps - 1)},
                            right[step] / weight[step],
                            weight[step]});
    const std::array<float, 2> weights = fit.solve(kCalibrationRidge);
    model.calibration[k] = {};
    for (float lead = -kMostLead; lead <= kMostLead; ++lead) {
      model.calibration[k].lead.push_back(lead);
      model.calibration[k].right.push_back(probability_of(weights, {1, lead}));
    }
  }
}

namespace {

/// Of each scan, which others may teach it.
std::vector<std::vector<size_t>> teachers_of(const std::vector<FitHuman>& humans) {
  std::map<std::string, std::set<std::string>> worn;
  for (const FitHuman& human : humans)
    worn[human.person].insert(human.garments.begin(), human.garments.end());
  const auto shares = [&](const std::string& l, const std::string& r) {
    return l == r || std::any_of(worn[l].begin(), worn[l].end(),
                                 [&](const std::string& garment) { return worn[r].count(garment) > 0; });
  };
  std::vector<std::vector<size_t>> teachers(humans.size());
  for (size_t i = 0; i < humans.size(); ++i)
    for (size_t j = 0; j < humans.size(); ++j)
      if (humans[i].is_generated ? !humans[j].is_generated || i % 2 != j % 2
                                 : !shares(humans[i].person, humans[j].person))
        teachers[i].push_back(j);
  return teachers;
}

template <typename T>
std::vector<T> gathered(const std::vector<std::vector<T>>& of, const std::vector<size_t>& indices) {
  std::vector<T> all;
  for (size_t i : indices) all.insert(all.end(), of[i].begin(), of[i].end());
  return all;
}

std::vector<LeadSample> gathered_leads(const std::vector<std::vector<LeadSample>>& of,
                                       const std::vector<FitHuman>& humans,
                                       const std::vector<size_t>& indices) {
  const std::vector<double> weight =
      weights_by_kind(indices.size(), [&](size_t i) { return humans[indices[i]].is_generated; });
  std::vector<LeadSample> all;
  for (size_t i = 0; i < indices.size(); ++i)
    for (LeadSample sample : of[indices[i]]) {
      sample.weight *= static_cast<float>(weight[i]);
      all.push_back(sample);
    }
  return all;
}

/// The part that most of each piece is, by the faces' classes.
std::vector<int> parts_of_pieces(const Garments& garments, const std::vector<uint8_t>& face_class,
                                 const std::vector<double>& face_area) {
  std::vector<std::array<double, kPartCount>> area(garments.garments.size());
  for (size_t f = 0; f < face_class.size(); ++f)
    if (garments.of_face[f] != Garments::kNone && face_class[f] < kClassCount)
      area[garments.of_face[f]][part_of(face_class[f])] += face_area[f];
  std::vector<int> parts;
  for (const auto& shares : area)
    parts.push_back(static_cast<int>(std::max_element(shares.begin(), shares.end()) - shares.begin()));
  return parts;
}

/// Of faces whose piece is what the label says and is labelled so, or that are of no piece: whether a piece
/// is what it is said to be is the piece's own doubt.
std::vector<LeadSample> lead_samples(const Labelling& labels, const Garments& garments,
                                     const RobotHuman& human) {
  double all = 0;
  for (double area : human.area) all += area;
  const std::vector<int> true_part = parts_of_pieces(garments, human.truth, human.area),
                         said_part = parts_of_pieces(garments, labels.face_class, human.area);
  std::vector<LeadSample> samples;
  for (size_t f = 0; f < labels.lead.size(); ++f) {
    const int said = part_of(labels.face_class[f]);
    const uint32_t g = garments.of_face[f];
    if (human.truth[f] >= kClassCount) continue;
    if (g != Garments::kNone && (said != said_part[g] || said != true_part[g])) continue;
    samples.push_back(
        {labels.lead[f], static_cast<float>(human.area[f] / all), said == part_of(human.truth[f]), said});
  }
  return samples;
}

}  // namespace

std::vector<LabelModel> cross_validated_models(const std::vector<FitHuman>& humans, LabelModel& of_all) {
  const std::vector<std::vector<size_t>> teachers = teachers_of(humans);
  std::vector<size_t> everyone(humans.size());
  std::iota(everyone.begin(), everyone.end(), size_t{0});
  const auto fit_faces = [&](const std::vector<size_t>& from, LabelModel& model) {
    std::vector<const FitHuman*> training;
    for (size_t i : from) training.push_back(&humans[i]);
    fit_parts(training, model);
  };
  std::vector<LabelModel> models(humans.size());
  std::vector<std::vector<PieceSample>> pieces(humans.size());
  std::vector<std::vector<LeadSample>> leads(humans.size());
  std::map<std::vector<size_t>, LabelModel> fitted;  // by teachers
  for (size_t i = 0; i < humans.size(); ++i) {
    const auto [model, is_new] = fitted.try_emplace(teachers[i]);
    if (is_new) fit_faces(teachers[i], model->second);
    models[i] = model->second;
    pieces[i] = piece_samples(Labeller(humans[i].features, humans[i].unit_cm, models[i]), *humans[i].human);
    for (PieceSample& piece : pieces[i]) piece.is_generated = humans[i].is_generated;
  }
  for (size_t i = 0; i < humans.size(); ++i) {
    models[i].pieces = fit_pieces(gathered(pieces, teachers[i]));
    Labeller labeller(humans[i].features, humans[i].unit_cm, models[i]);
    leads[i] = lead_samples(labeller.solve({}), labeller.garments(), *humans[i].human);
  }
  fitted.clear();
  for (size_t i = 0; i < humans.size(); ++i) {
    if (humans[i].is_generated) continue;  // they are not measured here
    const auto [model, is_new] = fitted.try_emplace(teachers[i]);
    if (is_new) fit_calibration(gathered_leads(leads, humans, teachers[i]), model->second);
    models[i].calibration = model->second.calibration;
  }
  fit_faces(everyone, of_all);
  of_all.pieces = fit_pieces(gathered(pieces, everyone));
  fit_calibration(gathered_leads(leads, humans, everyone), of_all);
  return models;
}

}  // namespace ohb
