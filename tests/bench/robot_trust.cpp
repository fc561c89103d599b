#include "tests/bench/robot_trust.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "dataset/commands/label.h"
#include "dataset/model/atomic_file.h"
#include "tests/bench/label_fit.h"

namespace ohb {
using namespace commands;
using namespace labelling;
using namespace surface;
namespace {

constexpr float kFarthest_cm = 5;
constexpr float kClaimStep = 0.005f;  // claims closer than that are one

std::vector<Vec3f> borders_of(const FaceGraph& graph, const std::vector<uint8_t>& face_class) {
  std::vector<Vec3f> points;
  for (const FaceEdge& edge : graph.edges)
    if (!edge.is_bridge && face_class[edge.a] != face_class[edge.b])
      points.push_back((graph.centre_cm[edge.a] + graph.centre_cm[edge.b]) / 2.0f);
  std::sort(points.begin(), points.end(), [](Vec3f l, Vec3f r) { return l.y < r.y; });
  return points;
}

/// Sum over `from` of the distance to the nearest of `to`; both ascend in y.
double sum_of_distances(const std::vector<Vec3f>& from, const std::vector<Vec3f>& to) {
  double sum = 0;
  for (const Vec3f& p : from) {
    float nearest = kFarthest_cm;
    auto near =
        std::lower_bound(to.begin(), to.end(), p.y - kFarthest_cm, [](Vec3f q, float y) { return q.y < y; });
    for (; near != to.end() && near->y <= p.y + nearest; ++near)
      nearest = std::min(nearest, length(*near - p));
    sum += nearest;
  }
  return sum;
}

/// Answers every question as the truth has it, with a stroke through the face that the question names.
std::vector<Stroke> answers_of(const Labeller& labeller, const Labelling& labels, const RobotHuman& human) {
  std::vector<Stroke> strokes;
  for (const GarmentQuestion& question : labels.questions) {
    ClassValues area{};
    for (size_t f = 0; f < human.truth.size(); ++f)
      if (labeller.garments().of_face[f] == question.garment && human.truth[f] < kClassCount)
        area[human.truth[f]] += static_cast<float>(human.area[f]);
    Stroke stroke = stroke_of_answer(
        labeller, question.garment,
        static_cast<MaterialClass>(std::max_element(area.begin(), area.end()) - area.begin()));
    stroke.time_s = static_cast<double>(strokes.size());
    strokes.push_back(stroke);
  }
  return strokes;
}

RobotTrust measure(const RobotHuman& human, Labeller& labeller) {
  const Labelling labels = labeller.solve({});
  RobotTrust trust = trust_of(human, labels, labeller.garments());
  const std::vector<Stroke> answers = answers_of(labeller, labels, human);
  const Labelling answered = labeller.solve(answers);
  trust.questions = answers.size();
  trust.answered = compare_with_truth(answered.face_class, human.truth, human.area).accuracy;
  if (labeller.features().graph.component_count == 1)
    trust.border_mm = border_error_mm(labeller.features().graph, answered.face_class, human.truth);
  return trust;
}

}  // namespace

void measure_trust(const std::vector<RobotHuman>& humans, const std::string& fitted, float leather_share) {
  std::vector<FitHuman> fits;
  for (const RobotHuman& human : humans) fits.push_back(prepare_fit(human));
  std::vector<LabelModel> models;
  if (fitted.empty()) {
    models.assign(humans.size(), installed_label_model());
  } else {
    LabelModel of_all;
    models = cross_validated_models(fits, of_all);
    write_file_atomically(fitted, label_model_json(of_all));
  }
  std::array<std::vector<RobotTrust>, 2> groups;
  for (size_t i = 0; i < humans.size(); ++i) {
    if (!fitted.empty() && fits[i].is_generated) continue;
    models[i].leather_share = leather_share;
    std::vector<RobotTrust>& people = groups[fits[i].is_generated];
    Labeller labeller(std::move(fits[i].features), fits[i].unit_cm, models[i]);
    people.push_back(measure(humans[i], labeller));
    std::printf("%s\n", trust_line(people.back()).c_str());
    std::fflush(stdout);
  }
  for (const std::vector<RobotTrust>& people : groups)
    if (!people.empty())
      std::printf("\n%zu scans%s\n%s", people.size(), &people == &groups[1] ? ", generated people" : "",
                  trust_text(people).c_str());
}

double border_error_mm(const FaceGraph& graph, const std::vector<uint8_t>& face_class,
                       const std::vector<uint8_t>& truth) {
  const std::vector<Vec3f> found = borders_of(graph, face_class), known = borders_of(graph, truth);
  const size_t count = found.size() + known.size();
  return count == 0 ? 0 : 10 * (sum_of_distances(found, known) + sum_of_distances(known, found)) / count;
}

RobotTrust trust_of(const RobotHuman& human, const Labelling& labels, const Garments& garments) {
  RobotTrust trust;
  trust.scan = human.name;
  double total = 0;
  std::map<std::pair<uint32_t, int>, Claim> claims;  // by piece and step
  for (size_t f = 0; f < labels.face_class.size(); ++f) {
    if (human.truth[f] >= kClassCount) continue;
    const double area = human.area[f], is_right = labels.face_class[f] == human.truth[f];
    total += area;
    trust.accuracy += area * is_right;
    if (labels.confidence[f] < kDoubtful) trust.unsure += area;
    if (labels.is_in_doubt[f]) trust.in_doubt += area;
    const bool is_body = garments.of_face[f] == Garments::kNone;
    const uint32_t piece = is_body ? Garments::kNone - labels.face_class[f] : garments.of_face[f];
    Claim& claim = claims[{piece, static_cast<int>(labels.confidence[f] / kClaimStep)}];
    claim.piece = piece;
    claim.area += area;
    claim.claimed += static_cast<float>(area) * labels.confidence[f];
    claim.right += area * is_right;
  }
  trust.accuracy /= total;
  trust.unsure /= total;
  trust.in_doubt /= total;
  for (auto& [key, claim] : claims) {
    if (!(claim.area > 0)) continue;
    claim.claimed /= static_cast<float>(claim.area);
    claim.area /= total;
    claim.right /= total;
    trust.claims.push_back(claim);
  }
  return trust;
}

std::string trust_line(const RobotTrust& of) {
  return fmt::format(
      "{:<28} right {:6.2f} %  unsure {:6.2f} %  or asked {:6.2f} %  questions {}  answered {:6.2f} %  "
      "borders "
      "{:5.1f} mm",
      of.scan, 100 * of.accuracy, 100 * of.unsure, 100 * of.in_doubt, of.questions, 100 * of.answered,
      of.border_mm);
}

std::string trust_text(const std::vector<RobotTrust>& people) {
  std::vector<double> right, answered, questions, unsure, doubt, beyond_unsure, beyond_doubt;
  std::vector<PersonClaims> claims;
  for (const RobotTrust& of : people) {
    right.push_back(of.accuracy);
    answered.push_back(of.answered);
    questions.push_back(static_cast<double>(of.questions));
    unsure.push_back(of.unsure);
    doubt.push_back(of.in_doubt);
    beyond_unsure.push_back(1 - of.accuracy - of.unsure);
    beyond_doubt.push_back(1 - of.accuracy - of.in_doubt);
    claims.push_back({of.scan.substr(0, of.scan.find('_')), of.claims});
  }
  for (auto* values : {&right, &answered, &questions, &unsure, &doubt, &beyond_unsure, &beyond_doubt})
    std::sort(values->begin(), values->end());
  const auto median = [](const std::vector<double>& v) {
    return 0.5 * (v[(v.size() - 1) / 2] + v[v.size() / 2]);
  };
  return fmt::format("right {:.2f} % (median), {:.2f} % (worst)\n", 100 * median(right),
                     100 * right.front()) +
         fmt::format(
             "less sure than {}: {:.2f} % (median), wrong beyond it at most {:.2f} %; or asked about: {:.2f} "
             "% (median), wrong beyond it at most {:.2f} %\n",
             kDoubtful, 100 * median(unsure), 100 * beyond_unsure.back(), 100 * median(doubt),
             100 * beyond_doubt.back()) +
         fmt::format(
             "questions {:.1f} (median), {:.0f} (most); answered {:.2f} % (median), {:.2f} % (worst)\n",
             median(questions), questions.back(), 100 * median(answered), 100 * answered.front()) +
         reliability_text(claims);
}

}  // namespace ohb
