// Labelling a scan: classes of its faces from rules, from finished classes, or from names.
// Later: a few strokes on the surface (`strokes`), automatic labels from geometry and colour.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dataset/production/label_report.h"

namespace ohb {

struct LabelJob {
  std::filesystem::path scan;
  /// At most one of these; without any, assets/rules_by_name.xml decides by the names of materials and
  /// groups.
  std::filesystem::path rules, faces;
  /// What the indices of `faces` and `truth` mean. Empty: "classes" of the JSON beside the file
  /// (x.labels.txt: x.json; else the scan's own), else skin, hair, fabric, leather.
  std::vector<std::string> classes;
  std::filesystem::path truth;   // known classes to compare with; empty: none
  std::string unit;              // as --unit, for areas in cm2; empty: guessed, no areas if that fails
  std::filesystem::path output;  // REGIONS folder, written whole or not at all
};

/// Writes REGIONS: regions.xml, faces.txt, class maps, report.json, report.txt. Throws InputError: files that
/// are missing or malformed, rules and faces at once, faces that nothing decides, output not writable.
LabelReport label_scan(const LabelJob& job);

/// The order of classes for a file of face classes (see LabelJob::classes). Throws InputError for a JSON
/// whose "classes" is not a list of names.
std::vector<std::string> class_order_of(const std::filesystem::path& faces,
                                        const std::filesystem::path& scan);

}  // namespace ohb
