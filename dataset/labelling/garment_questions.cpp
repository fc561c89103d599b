#include "dataset/labelling/garment_questions.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ohb::labelling {
namespace {

constexpr float kSure = 0.98f;       // no guess by colour is
constexpr float kTold = 0.995f;      // of a garment that a stroke names
constexpr float kException = 0.02f;  // how likely a stroke is to speak of its place alone
/// Nobody paints a garment by chance: a class has at least this chance once it is painted.
constexpr float kLeastChance = 0.05f;
constexpr float kTelling_cm2 = 6;       // a stroke on less is a correction and tells less
constexpr float kSmallGarment = 0.03f;  // of the whole area: it is not asked about for its size
constexpr float kFollows = 0.9f;        // chance that a small garment is of what the told one like it is
constexpr float kAnswer = 3;            // votes of a stroke through the garment's middle

/// What one stroke covers of one garment.
struct Cover {
  float area_cm2 = 0;
  Appearance look = Appearance::Zero();
  bool is_middle = false;
};

std::vector<Cover> covers_of(const Stroke& stroke, const FaceFeatures& features, double unit_cm,
                             const Garments& garments, float& all_cm2) {
  std::vector<Cover> covers(garments.garments.size());
  for (uint32_t f : faces_of_stroke(stroke, features.graph, unit_cm)) {
    const float area = features.graph.area_cm2[f];
    all_cm2 += area;
    if (garments.of_face[f] == Garments::kNone) continue;
    Cover& cover = covers[garments.of_face[f]];
    cover.area_cm2 += area;
    cover.look += area * features.appearance[f];
    if (f == garments.garments[garments.of_face[f]].face) cover.is_middle = true;
  }
  for (Cover& cover : covers)
    if (cover.area_cm2 > 0) cover.look /= cover.area_cm2;
  return covers;
}

/// How much a stroke speaks for the whole garment: nothing where an exception at its place is likelier.
float vote_of(const Cover& cover, float all_cm2, const Garment& garment, float chance,
              uint8_t material_class) {
  if (cover.is_middle) return kAnswer;
  if (!(cover.area_cm2 > 0.5f * all_cm2)) return 0;
  if (garment.part == kFabric && material_class >= kFabric) chance = std::max(chance, kLeastChance);
  const float like = std::exp(-0.5f * look_difference(cover.look, garment.look) / (1 + garment.variation));
  return chance * like > kException ? like * std::min(1.0f, cover.area_cm2 / kTelling_cm2) : 0;
}

/// The small ones that nothing tells are of what those are that look like them.
void follow_look_alikes(const Garments& garments, const std::vector<uint8_t>& told,
                        std::vector<ClassValues>& classes) {
  for (size_t g = 0; g < classes.size(); ++g) {
    const Garment& small = garments.garments[g];
    if (told[g] != kUnlabelled || small.part != kFabric || small.area_cm2 > kSmallGarment * garments.all_cm2)
      continue;
    float nearest = kAlike;
    uint8_t as = kUnlabelled;
    for (size_t other = 0; other < classes.size(); ++other) {
      const Garment& of = garments.garments[other];
      const float difference = look_difference(small.look, of.look);
      if (told[other] < kFabric || told[other] == kUnlabelled || of.is_shoe != small.is_shoe ||
          difference >= nearest)
        continue;
      nearest = difference;
      as = told[other];
    }
    if (as == kUnlabelled) continue;
    const float garment = std::accumulate(classes[g].begin() + kFabric, classes[g].end(), 0.0f);
    for (uint8_t c = kFabric; c < kClassCount; ++c)
      classes[g][c] = garment * (c == as ? kFollows : (1 - kFollows) / (kClassCount - kFabric - 1));
  }
}

/// The area that an answer may be expected to mend. Leather is the rarer guess, rests on colour alone, and
/// how sure it is moves with the people who taught it: its claim is not believed here.
double worth_cm2(const GarmentQuestion& question) {
  constexpr float kSurestLeather = 0.75f;
  const float sure =
      question.now == kLeather ? std::min(question.probability, kSurestLeather) : question.probability;
  return (1 - sure) * question.area_cm2;
}

}  // namespace

void hear_strokes(const FaceFeatures& features, double unit_cm, const Garments& garments,
                  std::vector<Stroke> strokes, std::vector<ClassValues>& classes) {
  std::stable_sort(strokes.begin(), strokes.end(),
                   [](const Stroke& l, const Stroke& r) { return l.time_s < r.time_s; });
  std::vector<ClassValues> votes(classes.size(), ClassValues{});
  std::vector<uint8_t> told(classes.size(), kUnlabelled);
  for (const Stroke& stroke : strokes) {
    const uint8_t c = stroke.material_class;
    float all_cm2 = 0;
    const std::vector<Cover> covers = covers_of(stroke, features, unit_cm, garments, all_cm2);
    for (size_t g = 0; g < covers.size(); ++g) {
      const float vote = vote_of(covers[g], all_cm2, garments.garments[g], classes[g][c], c);
      if (!(vote > 0)) continue;
      if (covers[g].is_middle) votes[g] = {};  // a later answer counts
      votes[g][c] += vote;
      if (told[g] == kUnlabelled || votes[g][c] > votes[g][told[g]]) told[g] = c;
    }
  }
  for (size_t g = 0; g < classes.size(); ++g)
    for (int c = 0; c < kClassCount && told[g] != kUnlabelled; ++c)
      classes[g][c] = told[g] == c ? kTold : (1 - kTold) / (kClassCount - 1);
  follow_look_alikes(garments, told, classes);
}

bool is_told(float probability) {
  return probability >= kTold - 1e-4f;
}

bool is_asked(const std::vector<GarmentQuestion>& questions, uint32_t garment) {
  return std::any_of(questions.begin(), questions.end(),
                     [&](const GarmentQuestion& question) { return question.garment == garment; });
}

std::vector<GarmentQuestion> open_questions(const Garments& garments,
                                            const std::vector<ClassValues>& classes) {
  std::vector<GarmentQuestion> questions;
  for (size_t g = 0; g < classes.size(); ++g) {
    GarmentQuestion question;
    std::array<uint8_t, kClassCount> order;  // garments' classes first, then hair and skin
    for (int c = 0; c < kClassCount; ++c)
      order[c] = static_cast<uint8_t>(c + kFabric < kClassCount ? c + kFabric : kClassCount - 1 - c);
    std::stable_sort(order.begin(), order.end(),
                     [&](uint8_t l, uint8_t r) { return classes[g][l] > classes[g][r]; });
    question.name = garments.garments[g].name;
    question.garment = g;
    question.now = order[0];
    question.rival = order[1];
    question.probability = classes[g][order[0]];
    question.area_cm2 = garments.garments[g].area_cm2;
    question.face = garments.garments[g].face;
    const bool is_large_guess = question.probability < kSure &&
                                question.area_cm2 > kLargeGuess * garments.all_cm2 &&
                                !garments.garments[g].is_on_head;
    const bool is_worth_it = worth_cm2(question) > kWorthAsking * garments.all_cm2;
    if (!is_told(question.probability) && (is_large_guess || is_worth_it)) questions.push_back(question);
  }
  std::stable_sort(questions.begin(), questions.end(),
                   [](const auto& l, const auto& r) { return worth_cm2(l) > worth_cm2(r); });
  if (questions.size() > kMostQuestions) questions.resize(kMostQuestions);
  std::stable_sort(questions.begin(), questions.end(),
                   [](const auto& l, const auto& r) { return l.area_cm2 > r.area_cm2; });
  return questions;
}

void say_as_labelled(const FaceGraph& graph, const Garments& garments,
                     const std::vector<ClassValues>& classes, const std::vector<uint8_t>& face_class,
                     std::vector<GarmentQuestion>& questions) {
  std::vector<ClassValues> area_cm2(classes.size(), ClassValues{});
  for (size_t f = 0; f < face_class.size(); ++f)
    if (garments.of_face[f] != Garments::kNone)
      area_cm2[garments.of_face[f]][face_class[f]] += graph.area_cm2[f];
  for (GarmentQuestion& question : questions) {
    const ClassValues& area = area_cm2[question.garment];
    if (area[question.rival] <= area[question.now]) continue;
    std::swap(question.now, question.rival);
    question.probability = classes[question.garment][question.now];
  }
}

}  // namespace ohb::labelling
