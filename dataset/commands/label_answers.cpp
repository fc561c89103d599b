#include "dataset/commands/label_answers.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "dataset/model/error.h"

namespace ohb::commands {
namespace {

InputError answer_error(const std::string& answer, const std::string& cause, const std::string& mend) {
  return InputError("", "--answer " + answer, cause, mend);
}

std::string listed(const std::vector<labelling::GarmentQuestion>& questions) {
  std::string names;
  for (const labelling::GarmentQuestion& question : questions)
    names += (names.empty() ? "" : ", ") + question.name;
  return names.empty() ? "nothing is asked: leave it out" : "answer one of: " + names;
}

size_t garment_of(const std::string& answer, const std::string& name, labelling::Labeller& labeller) {
  const std::vector<labelling::Garment>& garments = labeller.garments().garments;
  for (size_t g = 0; g < garments.size(); ++g)
    if (garments[g].name == name) return g;
  const std::vector<labelling::GarmentQuestion> questions = labeller.solve({}).questions;
  for (size_t i = 0; i < questions.size(); ++i)
    if (name == std::to_string(i + 1)) return questions[i].garment;
  throw answer_error(answer, "there is no question '" + name + "'", listed(questions));
}

}  // namespace

std::vector<labelling::Stroke> strokes_of_answers(const std::vector<std::string>& answers,
                                                  labelling::Labeller& labeller, double after_s) {
  std::vector<labelling::Stroke> strokes;
  std::set<size_t> answered;
  for (const std::string& answer : answers) {
    const size_t equals = answer.find('=');
    const MaterialClass given =
        equals == std::string::npos ? kUnlabelled : class_from_name(answer.substr(equals + 1));
    if (given == kUnlabelled)
      throw answer_error(answer, "is no NAME=CLASS", "write for example trousers=leather");
    const size_t garment = garment_of(answer, answer.substr(0, equals), labeller);
    if (!answered.insert(garment).second)
      throw answer_error(answer, "'" + labeller.garments().garments[garment].name + "' is answered twice",
                         "keep one of the answers");
    strokes.push_back(labelling::stroke_of_answer(labeller, garment, given));
    strokes.back().time_s = after_s + static_cast<double>(strokes.size());
  }
  return strokes;
}

std::string stroke_line(const labelling::Stroke& stroke) {
  const labelling::StrokePoint& point = stroke.points.front();
  return fmt::format(
      R"(<stroke class="{}" radius_cm="{}" time_s="{}"><point face="{}" at="{},{},{}"/></stroke>)",
      kClassNames[stroke.material_class], stroke.radius_cm, stroke.time_s, point.face, point.at.x, point.at.y,
      point.at.z);
}

}  // namespace ohb::commands
