// Labelling a scan: classes of its faces from rules, finished classes, names, strokes on the surface, or from
// body, colour and texture alone.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dataset/commands/label_report.h"
#include "dataset/labelling/piece_weights.h"

namespace ohb::commands {

/// Whether borders follow the picture through faces (see texel_labels.h). kAuto: where classes are inferred
/// and the faces along borders are large; finished classes, rules and names are taken at their word.
enum class RefineBorders { kAuto, kOn, kOff };

struct LabelJob {
  std::filesystem::path scan;
  /// At most one of these four. Without any, assets/rules_by_name.xml decides by the names of materials and
  /// groups, and start labels (see start_labels.h) where these say nothing.
  std::filesystem::path rules, faces, strokes;
  bool automatic = false;  // start labels for every face, whatever the names say
  /// What the indices of `faces` and `truth` mean. Empty: "classes" of the JSON beside the file
  /// (x.labels.txt: x.json; else the scan's own), else skin, hair, fabric, leather.
  std::vector<std::string> classes;
  /// "NAME=CLASS": answers to questions of a run before (see label_answers.h), where classes are inferred.
  std::vector<std::string> answers;
  std::filesystem::path truth;                     // known classes to compare with; empty: none
  float leather_share = labelling::kLeatherShare;  // of garments, shoes apart (see LabelModel)
  std::string unit;  // as --unit; empty: guessed. Needed for strokes and start labels
  std::string up;    // as turn_up (scan_unit.h); empty: Y, and it must not seem to lie
  RefineBorders refine = RefineBorders::kAuto;
  std::filesystem::path output;  // REGIONS folder, written whole or not at all
};

/// Writes REGIONS: regions.xml, faces.txt, class maps, previews, report.json, report.txt; with strokes or
/// start labels confidence maps too, and the strokes, answers among them. Throws InputError: files that are
/// missing or malformed, rules, faces and strokes at once, strokes of another scan, a rule file that leaves
/// faces undecided, a unit that is needed and not known, output not writable.
LabelReport label_scan(const LabelJob& job);

/// The order of classes for a file of face classes (see LabelJob::classes). Throws InputError for a JSON
/// whose "classes" is not a list of names.
std::vector<std::string> class_order_of(const std::filesystem::path& faces,
                                        const std::filesystem::path& scan);

}  // namespace ohb::commands
