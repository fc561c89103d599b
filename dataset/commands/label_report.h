// What labelling did: shares of the classes, what each rule took, and agreement with known classes.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "dataset/commands/label_rules.h"
#include "dataset/labelling/doubt.h"
#include "dataset/labelling/texel_labels.h"
#include "dataset/model/regions.h"
#include "dataset/model/scan.h"

namespace ohb::commands {

struct ClassShare {
  uint64_t faces = 0;
  double area = 0;  // in the square of the scan's unit
};

/// Agreement with known classes, weighted by area: counting faces would overrate dense parts.
/// Faces without a known class (255) do not count.
struct TruthComparison {
  double accuracy = 0;  // share of the area whose class is right
  /// Intersection over union of the areas; nothing for a class that occurs neither here nor in the truth.
  std::array<std::optional<double>, kClassCount> iou;
  double mean_iou = 0;  // over the classes that have one
  /// Share of the area by [true class][class given], the last column unlabelled; sums to 1.
  std::array<std::array<double, kClassCount + 1>, kClassCount> confusion{};
};

struct RuleReport {
  std::string text;
  MaterialClass material_class = kUnlabelled;
  uint64_t matched = 0;                                    // faces
  ClassShare took;                                         // matched and not taken by a later rule
  std::vector<std::pair<std::string, std::string>> words;  // as RuleOutcome::words
};

/// A garment whose class only the user knows; see garment_questions.h.
struct QuestionReport {
  std::string name;
  MaterialClass now = kFabric, rival = kLeather;
  double probability = 0;  // of `now`
  double area_cm2 = 0;
  uint32_t face = 0;
  Vec3f at;                              // its middle, in the scan's unit
  std::string now_stroke, rival_stroke;  // elements of strokes.xml that answer it
};

/// What is known of labels that were inferred from strokes, or from body, colour and texture.
struct InferenceReport {
  uint64_t strokes = 0, faces = 0;  // faces: those whose class was inferred
  double confidence = 0;            // mean over their area: the share that may be expected to be right
  double doubtful_area = 0;         // of faces below kDoubtful, in the square of the scan's unit
  std::optional<labelling::SuggestedStroke> suggested;
  std::vector<QuestionReport> questions;  // largest first; the first is number 1
};

struct LabelReport {
  /// method: "rules", "faces", "names", "strokes", "automatic", or "names, and automatic where they say
  /// nothing".
  std::string scan, scan_sha256, method;
  std::optional<double> unit_cm;
  double total_area = 0;
  std::array<ClassShare, kClassCount> classes;
  ClassShare unlabelled;
  std::vector<RuleReport> rules;
  std::optional<InferenceReport> inferred;
  std::optional<labelling::TexelLabels::Summary> texel_borders;  // if it was tried
  std::optional<TruthComparison> truth;
  std::vector<std::string> warnings;
};

/// Area of each face in the square of the scan's unit.
std::vector<double> face_areas(const Scan& scan);

/// Fills the shares of the classes.
void report_classes(const std::vector<uint8_t>& face_class, const std::vector<double>& area,
                    LabelReport& report);
/// Fills the rules; `warn_of_idle` adds a warning for each rule that took nothing.
void report_rules(const LabelRules& rules, const RuleOutcome& outcome, const std::vector<double>& area,
                  bool warn_of_idle, LabelReport& report);

TruthComparison compare_with_truth(const std::vector<uint8_t>& face_class, const std::vector<uint8_t>& truth,
                                   const std::vector<double>& area);

/// For report.json and --json; areas in cm2 where the unit is known.
nlohmann::ordered_json to_json(const LabelReport& report);
/// For people.
std::string to_text(const LabelReport& report);

}  // namespace ohb::commands
