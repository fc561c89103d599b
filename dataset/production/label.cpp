#include "dataset/production/label.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "dataset/model/atomic_file.h"
#include "dataset/model/data_files.h"
#include "dataset/model/error.h"
#include "dataset/model/scan_unit.h"
#include "dataset/production/label_maps.h"

namespace ohb {
namespace fs = std::filesystem;
namespace {

/// "a, b and 3 more": the distinct materials of the faces without a class.
std::string undecided_materials(const Scan& scan, const std::vector<uint8_t>& face_class) {
  std::vector<std::string> names;
  for (size_t f = 0; f < face_class.size(); ++f) {
    const std::string& name = scan.materials[scan.face_material[f]].name;
    if (face_class[f] == kUnlabelled && std::find(names.begin(), names.end(), name) == names.end())
      names.push_back(name);
  }
  constexpr size_t kNamed = 5;
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), kNamed); ++i) text += (i ? ", '" : "'") + names[i] + "'";
  return names.size() > kNamed ? text + " and " + std::to_string(names.size() - kNamed) + " more" : text;
}

void expect_decided(const Scan& scan, const LabelJob& job, const std::vector<uint8_t>& face_class) {
  const size_t undecided = static_cast<size_t>(std::count(face_class.begin(), face_class.end(), kUnlabelled));
  if (undecided == 0) return;
  const std::string count = std::to_string(undecided) + " of " + std::to_string(face_class.size()) + " faces";
  const std::string where = " (material " + undecided_materials(scan, face_class) + ")";
  if (!job.rules.empty())
    throw InputError(job.rules.string(), "", "no rule takes " + count + where,
                     "add rules, or default=\"...\" to <rules>");
  throw InputError(job.scan.string(), "", "names do not tell the class of " + count + where,
                   "give --rules with a class for them, or --faces with finished classes");
}

std::vector<uint8_t> classes_by_rules(const Scan& scan, const LabelJob& job, const std::vector<double>& areas,
                                      LabelReport& report) {
  const bool is_given = !job.rules.empty();
  report.method = is_given ? "rules" : "names";
  const LabelRules rules = read_label_rules(is_given ? job.rules : program_file("assets/rules_by_name.xml"));
  const std::vector<Vec3f> colours = rules.use_colour() ? mean_face_colours(scan) : std::vector<Vec3f>();
  RuleOutcome outcome;
  std::vector<uint8_t> face_class = apply_rules(rules, scan, colours, outcome);
  report_rules(rules, outcome, areas, is_given, report);
  expect_decided(scan, job, face_class);
  return face_class;
}

std::vector<uint8_t> classes_of_file(const fs::path& file, const Scan& scan, const LabelJob& job) {
  return read_face_classes(file, scan.face_count(),
                           job.classes.empty() ? class_order_of(file, job.scan) : job.classes);
}

}  // namespace

std::vector<std::string> class_order_of(const fs::path& faces, const fs::path& scan) {
  fs::path without_labels = faces.parent_path() / faces.stem();
  if (without_labels.extension() == ".labels")
    without_labels = without_labels.parent_path() / without_labels.stem();
  for (fs::path candidate : {without_labels, scan.parent_path() / scan.stem()}) {
    candidate += ".json";
    if (!fs::is_regular_file(candidate)) continue;
    const nlohmann::json json = nlohmann::json::parse(read_file(candidate), nullptr, false);
    if (json.is_discarded())
      throw InputError(candidate.string(), "", "is not well-formed JSON", "correct it");
    if (!json.is_object() || !json.contains("classes")) continue;
    const nlohmann::json& classes = json["classes"];
    const bool is_list =
        classes.is_array() && !classes.empty() &&
        std::all_of(classes.begin(), classes.end(), [](const auto& c) { return c.is_string(); });
    if (!is_list)
      throw InputError(candidate.string(), "classes", "is not a list of names",
                       "write for example [\"skin\", \"hair\"]");
    return classes.get<std::vector<std::string>>();
  }
  return {};
}

LabelReport label_scan(const LabelJob& job) {
  if (!job.rules.empty() && !job.faces.empty())
    throw InputError("", "--rules", "and --faces are both given", "give one of them");
  AtomicFolder folder(job.output);
  const Scan scan = read_scan(job.scan);
  const std::vector<double> areas = face_areas(scan);
  LabelReport report;
  report.scan = job.scan.filename().string();
  report.unit_cm = job.unit.empty() ? guess_unit(scan).unit_cm : unit_cm_of(job.unit);
  Regions regions;
  report.scan_sha256 = regions.scan_sha256 = sha256_of_file(job.scan);
  if (job.faces.empty()) {
    regions.face_class = classes_by_rules(scan, job, areas, report);
  } else {
    report.method = "faces";
    regions.face_class = classes_of_file(job.faces, scan, job);
  }
  report_classes(regions.face_class, areas, report);
  if (report.unlabelled.faces > 0)
    report.warnings.push_back(std::to_string(report.unlabelled.faces) +
                              " faces are unlabelled; bake needs all");
  if (!job.truth.empty())
    report.truth = compare_with_truth(regions.face_class, classes_of_file(job.truth, scan, job), areas);
  write_regions(folder.path(), regions);
  for (const std::string& name : write_class_maps(folder.path(), scan, regions.face_class))
    report.warnings.push_back("material '" + name + "' has faces without usable UVs: no class map for it");
  write_file_atomically(folder.path() / "report.json", to_json(report).dump(2) + "\n");
  write_file_atomically(folder.path() / "report.txt", to_text(report));
  folder.commit();
  return report;
}

}  // namespace ohb
