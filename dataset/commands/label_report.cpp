#include "dataset/commands/label_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace ohb::commands {
namespace {

// A rule by name can list dozens of words; the table needs only enough to tell it from the others.
std::string shortened(const std::string& text) {
  constexpr size_t kLongest = 60;
  return text.size() <= kLongest ? text : text.substr(0, kLongest) + "...";
}

/// "skin: the word 'head' of Wolf3D_Head, ..." of a rule with words, else the rule.
std::string deciding_text(const RuleReport& rule) {
  if (rule.words.empty()) return shortened(rule.text);
  constexpr size_t kNamed = 6;
  std::string text = std::string(kClassNames[rule.material_class]) + ":";
  for (size_t i = 0; i < std::min(kNamed, rule.words.size()); ++i)
    text += fmt::format("{} '{}' in {}", i ? "," : "", rule.words[i].second, shortened(rule.words[i].first));
  return text + (rule.words.size() > kNamed ? fmt::format(" and {} more", rule.words.size() - kNamed) : "");
}

double share(double part, double whole) {
  return whole > 0 ? part / whole : 0;
}

nlohmann::ordered_json share_json(const ClassShare& share_of, const LabelReport& report) {
  nlohmann::ordered_json json{{"faces", share_of.faces},
                              {"area_share", share(share_of.area, report.total_area)}};
  if (report.unit_cm) json["area_cm2"] = share_of.area * *report.unit_cm * *report.unit_cm;
  return json;
}

nlohmann::ordered_json truth_json(const TruthComparison& truth) {
  nlohmann::ordered_json json{{"accuracy", truth.accuracy}, {"mean_iou", truth.mean_iou}};
  for (int c = 0; c < kClassCount; ++c)
    json["iou"][kClassNames[c]] = truth.iou[c] ? nlohmann::ordered_json(*truth.iou[c]) : nullptr;
  json["confusion"] = truth.confusion;
  json["confusion_columns"] = kClassNames;
  json["confusion_columns"].push_back("unlabelled");
  return json;
}

nlohmann::ordered_json inference_json(const InferenceReport& inferred, const LabelReport& report) {
  nlohmann::ordered_json json{{"strokes", inferred.strokes},
                              {"faces", inferred.faces},
                              {"confidence", inferred.confidence},
                              {"doubtful_area_share", share(inferred.doubtful_area, report.total_area)}};
  json["suggested_stroke"] = nullptr;
  if (inferred.suggested)
    json["suggested_stroke"] = {{"face", inferred.suggested->face},
                                {"now", kClassNames[inferred.suggested->now]},
                                {"rival", kClassNames[inferred.suggested->rival]},
                                {"area_cm2", inferred.suggested->area_cm2}};
  json["questions"] = nlohmann::ordered_json::array();
  for (const QuestionReport& question : inferred.questions)
    json["questions"].push_back({{"id", question.name},
                                 {"number", json["questions"].size() + 1},
                                 {"now", kClassNames[question.now]},
                                 {"rival", kClassNames[question.rival]},
                                 {"probability", question.probability},
                                 {"area_cm2", question.area_cm2},
                                 {"face", question.face},
                                 {"at", {question.at.x, question.at.y, question.at.z}},
                                 {"stroke_now", question.now_stroke},
                                 {"stroke_rival", question.rival_stroke}});
  return json;
}

std::string inference_text(const InferenceReport& inferred, const LabelReport& report) {
  std::string text = fmt::format(
      "  inferred from {} strokes: {} faces, mean confidence {:.2f}, {:.2f} % of the "
      "area in doubt\n",
      inferred.strokes, inferred.faces, inferred.confidence,
      100 * share(inferred.doubtful_area, report.total_area));
  if (inferred.suggested && inferred.questions.empty())
    text += fmt::format("  a stroke at face {} would settle most: {} or {}? ({:.0f} cm2)\n",
                        inferred.suggested->face, kClassNames[inferred.suggested->now],
                        kClassNames[inferred.suggested->rival], inferred.suggested->area_cm2);
  if (!inferred.questions.empty())
    text +=
        "  colour cannot tell (the hatched parts of preview.svg); answer with --answer, or with the "
        "stroke:\n";
  for (size_t i = 0; i < inferred.questions.size(); ++i) {
    const QuestionReport& question = inferred.questions[i];
    text += fmt::format("  {}. {}, {:.0f} cm2: {} or {}? now {}, {:.0f} % sure: --answer {}={}\n       {}\n",
                        i + 1, question.name, question.area_cm2, kClassNames[question.now],
                        kClassNames[question.rival], kClassNames[question.now], 100 * question.probability,
                        question.name, kClassNames[question.rival], question.rival_stroke);
  }
  return text;
}

nlohmann::ordered_json borders_json(const labelling::TexelLabels::Summary& borders) {
  nlohmann::ordered_json json{
      {"refined", borders.is_refined}, {"border_cm", borders.border_cm}, {"edge_mm", 10 * borders.edge_cm}};
  if (!borders.is_refined) {
    json["reason"] = borders.reason;
    return json;
  }
  json["band_mm"] = 10 * borders.band_cm;
  json["texel_mm"] = 10 * borders.texel_cm;
  json["texels"] = borders.texels;
  json["changed_cm2"] = borders.changed_cm2;
  json["shift_mm"] = borders.shift_mm();
  return json;
}

std::string borders_text(const labelling::TexelLabels::Summary& borders) {
  if (!borders.is_refined) return "  borders follow the faces: " + borders.reason + "\n";
  return fmt::format(
      "  borders follow the picture: {:.0f} cm2 changed class within {:.1f} mm of {:.0f} cm of borders, "
      "{:.2f} mm "
      "in the mean ({} texels of {:.2f} mm)\n",
      borders.changed_cm2, 10 * borders.band_cm, borders.border_cm, borders.shift_mm(), borders.texels,
      10 * borders.texel_cm);
}

std::string truth_text(const TruthComparison& truth) {
  std::string text = fmt::format("against the truth: accuracy {:.2f} % of the area, mean IoU {:.3f}\n",
                                 100 * truth.accuracy, truth.mean_iou);
  text += fmt::format("  {:<18}", "% of area, true:");
  for (const char* name : kClassNames) text += fmt::format("{:>8}", name);
  text += fmt::format("{:>12}{:>8}\n", "unlabelled", "IoU");
  for (int c = 0; c < kClassCount; ++c) {
    const auto& row = truth.confusion[c];
    text += fmt::format("  {:<18}", kClassNames[c]);
    for (int other = 0; other < kClassCount; ++other) text += fmt::format("{:>8.2f}", 100 * row[other]);
    text += fmt::format("{:>12.2f}{:>8}\n", 100 * row[kClassCount],
                        truth.iou[c] ? fmt::format("{:.3f}", *truth.iou[c]) : "-");
  }
  return text;
}

}  // namespace

std::vector<double> face_areas(const Scan& scan) {
  std::vector<double> areas(scan.face_count(), 0);
  for (const ScanTriangle& triangle : triangulate(scan)) {
    const Vec3f a = scan.positions[scan.corners[triangle.corner[0]].position];
    const Vec3f b = scan.positions[scan.corners[triangle.corner[1]].position];
    const Vec3f c = scan.positions[scan.corners[triangle.corner[2]].position];
    const double u[3] = {double(b.x) - a.x, double(b.y) - a.y, double(b.z) - a.z};
    const double v[3] = {double(c.x) - a.x, double(c.y) - a.y, double(c.z) - a.z};
    const double x = u[1] * v[2] - u[2] * v[1], y = u[2] * v[0] - u[0] * v[2], z = u[0] * v[1] - u[1] * v[0];
    areas[triangle.face] += std::sqrt(x * x + y * y + z * z) / 2;
  }
  return areas;
}

void report_classes(const std::vector<uint8_t>& face_class, const std::vector<double>& area,
                    LabelReport& report) {
  for (size_t f = 0; f < face_class.size(); ++f) {
    ClassShare& to = face_class[f] < kClassCount ? report.classes[face_class[f]] : report.unlabelled;
    ++to.faces;
    to.area += area[f];
    report.total_area += area[f];
  }
}

void report_rules(const LabelRules& rules, const RuleOutcome& outcome, const std::vector<double>& area,
                  bool warn_of_idle, LabelReport& report) {
  for (size_t r = 0; r < rules.rules.size(); ++r)
    report.rules.push_back(
        {rules.rules[r].text, rules.rules[r].material_class, outcome.matched[r], {}, outcome.words[r]});
  for (size_t f = 0; f < outcome.rule_of_face.size(); ++f) {
    if (outcome.rule_of_face[f] < 0) continue;
    ClassShare& took = report.rules[static_cast<size_t>(outcome.rule_of_face[f])].took;
    ++took.faces;
    took.area += area[f];
  }
  if (!warn_of_idle) return;
  for (size_t r = 0; r < report.rules.size(); ++r) {
    const RuleReport& rule = report.rules[r];
    if (rule.took.faces > 0) continue;
    report.warnings.push_back(
        fmt::format("rule {} ({}) takes no face: {}", r + 1, rule.text,
                    rule.matched > 0 ? fmt::format("later rules take all {} that it matches", rule.matched)
                                     : "it matches none; check its names and ranges"));
  }
}

TruthComparison compare_with_truth(const std::vector<uint8_t>& face_class, const std::vector<uint8_t>& truth,
                                   const std::vector<double>& area) {
  TruthComparison comparison;
  std::array<double, kClassCount> given{}, known{};
  double total = 0;
  for (size_t f = 0; f < truth.size(); ++f) {
    if (truth[f] >= kClassCount) continue;
    const int column = face_class[f] < kClassCount ? face_class[f] : kClassCount;
    comparison.confusion[truth[f]][column] += area[f];
    known[truth[f]] += area[f];
    if (column < kClassCount) given[column] += area[f];
    total += area[f];
  }
  int counted = 0;
  for (int c = 0; c < kClassCount; ++c) {
    const double right = comparison.confusion[c][c], either = given[c] + known[c] - right;
    comparison.accuracy += share(right, total);
    for (double& cell : comparison.confusion[c]) cell = share(cell, total);
    if (!(either > 0)) continue;
    comparison.iou[c] = right / either;
    comparison.mean_iou += right / either;
    ++counted;
  }
  if (counted > 0) comparison.mean_iou /= counted;
  return comparison;
}

nlohmann::ordered_json to_json(const LabelReport& report) {
  nlohmann::ordered_json json{
      {"scan", report.scan}, {"scan_sha256", report.scan_sha256}, {"method", report.method}};
  json["unit_cm"] = report.unit_cm ? nlohmann::ordered_json(*report.unit_cm) : nullptr;
  for (int c = 0; c < kClassCount; ++c)
    json["classes"][kClassNames[c]] = share_json(report.classes[c], report);
  json["unlabelled"] = share_json(report.unlabelled, report);
  json["rules"] = nlohmann::ordered_json::array();
  for (const RuleReport& rule : report.rules) {
    json["rules"].push_back(
        {{"rule", rule.text}, {"matched_faces", rule.matched}, {"took", share_json(rule.took, report)}});
    for (const auto& [name, word] : rule.words)
      json["rules"].back()["words"].push_back({{"name", name}, {"word", word}});
  }
  if (report.inferred) json["inferred"] = inference_json(*report.inferred, report);
  if (report.texel_borders) json["texel_borders"] = borders_json(*report.texel_borders);
  if (report.truth) json["truth"] = truth_json(*report.truth);
  json["warnings"] = report.warnings;
  return json;
}

std::string to_text(const LabelReport& report) {
  std::string text = fmt::format("{}: labelled by {}\n", report.scan, report.method);
  const auto line = [&](const std::string& name, const ClassShare& of) {
    text += fmt::format("  {:<12}{:>9} faces{:>8.2f} % of the area", name, of.faces,
                        100 * share(of.area, report.total_area));
    if (report.unit_cm) text += fmt::format("{:>10.0f} cm2", of.area * *report.unit_cm * *report.unit_cm);
    text += "\n";
  };
  for (int c = 0; c < kClassCount; ++c) line(kClassNames[c], report.classes[c]);
  if (report.unlabelled.faces > 0) line("unlabelled", report.unlabelled);
  for (size_t r = 0; r < report.rules.size(); ++r)
    if (report.rules[r].took.faces > 0)
      text += fmt::format(
          "  rule {}: {} faces, {:.2f} % of the area ({})\n", r + 1, report.rules[r].took.faces,
          100 * share(report.rules[r].took.area, report.total_area), deciding_text(report.rules[r]));
  if (report.inferred) text += inference_text(*report.inferred, report);
  if (report.texel_borders) text += borders_text(*report.texel_borders);
  if (report.truth) text += truth_text(*report.truth);
  for (const std::string& warning : report.warnings) text += "warning: " + warning + "\n";
  return text;
}

}  // namespace ohb::commands
