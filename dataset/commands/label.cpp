#include "dataset/commands/label.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "dataset/commands/label_answers.h"
#include "dataset/commands/label_maps.h"
#include "dataset/commands/label_preview.h"
#include "dataset/commands/picture_files.h"
#include "dataset/labelling/face_colours.h"
#include "dataset/labelling/labeller.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/data_files.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"
#include "dataset/model/scan_unit.h"

namespace ohb::commands {
namespace fs = std::filesystem;
namespace {

struct Labels {
  std::vector<uint8_t> face_class;
  std::vector<float> confidence;           // empty if nothing was inferred
  std::vector<bool> is_given;              // by names or strokes; empty as confidence
  std::vector<uint32_t> question_of_face;  // index of the report's question; empty as confidence
  std::vector<labelling::Stroke> strokes;
};

/// What there is to label.
struct Subject {
  const Scan& scan;
  std::vector<double> areas;                      // of the faces, in the scan's unit
  std::optional<labelling::ScanSurface> surface;  // if the unit is known
};

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

size_t undecided_faces(const std::vector<uint8_t>& face_class) {
  return static_cast<size_t>(std::count(face_class.begin(), face_class.end(), kUnlabelled));
}

/// Whether colour can tell anything at all.
bool has_picture(const Scan& scan) {
  return std::any_of(scan.materials.begin(), scan.materials.end(), [](const ScanMaterial& material) {
    return !material.diffuse.empty() || material.has_vertex_colours;
  });
}

/// What only the user can tell of the faces that are not given, with the strokes that tell it.
void report_questions(const labelling::Labeller& labeller, const labelling::Labelling& inferred,
                      Labels& labels, InferenceReport& report) {
  labels.question_of_face.assign(labels.face_class.size(), labelling::Garments::kNone);
  for (const labelling::GarmentQuestion& question : inferred.questions) {
    if (labels.is_given[question.face]) continue;
    QuestionReport of;
    of.name = question.name;
    of.now = static_cast<MaterialClass>(question.now);
    of.rival = static_cast<MaterialClass>(question.rival);
    of.probability = question.probability;
    of.area_cm2 = question.area_cm2;
    of.face = question.face;
    const labelling::Stroke stroke = labelling::stroke_of_answer(labeller, question.garment, of.now);
    of.at = stroke.points.front().at;
    of.now_stroke = stroke_line(stroke);
    of.rival_stroke = stroke_line(labelling::stroke_of_answer(labeller, question.garment, of.rival));
    for (size_t f = 0; f < labels.face_class.size(); ++f)
      if (labeller.garments().of_face[f] == question.garment && !labels.is_given[f])
        labels.question_of_face[f] = static_cast<uint32_t>(report.questions.size());
    report.questions.push_back(of);
  }
}

/// Takes the inferred class of each face that has none.
void infer_classes(labelling::Labeller& labeller, const std::vector<labelling::Stroke>& strokes,
                   const std::vector<double>& areas, Labels& labels, LabelReport& report) {
  const labelling::Labelling inferred = labeller.solve(strokes);
  InferenceReport of;
  of.strokes = strokes.size();
  labels.confidence.assign(areas.size(), 1);
  labels.is_given.assign(areas.size(), true);
  double area = 0;
  for (size_t f = 0; f < areas.size(); ++f) {
    if (labels.face_class[f] != kUnlabelled) continue;
    labels.face_class[f] = inferred.face_class[f];
    labels.confidence[f] = inferred.confidence[f];
    labels.is_given[f] = false;
    ++of.faces;
    area += areas[f];
    of.confidence += areas[f] * inferred.confidence[f];
    if (inferred.is_in_doubt[f]) of.doubtful_area += areas[f];
  }
  for (uint32_t f : labelling::stroked_faces(strokes, labeller.features().graph, labeller.unit_cm()).face)
    labels.is_given[f] = true;
  if (area > 0) of.confidence /= area;
  if (inferred.suggested && of.faces == areas.size()) of.suggested = inferred.suggested;
  report_questions(labeller, inferred, labels, of);
  report.inferred = of;
  if (!labeller.start().found_face)
    report.warnings.push_back(
        "there is no skin where a face should be: does the scan stand upright (+Y) and face +Z? If the face "
        "is "
        "covered, mark skin with --strokes");
  if (labeller.start().found_face && of.faces == areas.size() &&
      std::count(labels.face_class.begin(), labels.face_class.end(), kHair) == 0)
    report.warnings.push_back("no face became hair: if the person is not bald, mark hair with --strokes");
  report.warnings.insert(report.warnings.end(), inferred.warnings.begin(), inferred.warnings.end());
}

/// Throws InputError if the unit is not known.
const labelling::ScanSurface& surface_of(const Subject& subject, const LabelJob& job) {
  if (!subject.surface)
    resolve_unit_cm(subject.scan, job.unit.empty() ? std::nullopt : std::optional(job.unit));
  return *subject.surface;
}

void label_by_strokes(const Subject& subject, const LabelJob& job, Labels& labels, LabelReport& report) {
  const labelling::ScanSurface& surface = surface_of(subject, job);
  const Scan& scan = subject.scan;
  if (job.strokes.empty() && !has_picture(scan))
    throw InputError(job.scan.string(), "", "has no picture: there is no colour to infer classes from",
                     "give --rules, --faces or --strokes");
  labelling::Strokes strokes;
  if (!job.strokes.empty()) strokes = labelling::read_strokes(job.strokes, scan, surface.unit_cm);
  if (!strokes.scan_sha256.empty() && strokes.scan_sha256 != report.scan_sha256)
    throw InputError(job.strokes.string(), "",
                     "was painted on another scan than " + report.scan + " (the hash of the file differs)",
                     "give the strokes of this scan");
  report.method = job.strokes.empty() ? "automatic" : "strokes";
  labels.face_class.assign(scan.face_count(), kUnlabelled);
  labelling::Labeller labeller(surface, {}, job.leather_share);
  double last_s = 0;
  for (const labelling::Stroke& stroke : strokes.strokes) last_s = std::max(last_s, stroke.time_s);
  const std::vector<labelling::Stroke> answers = strokes_of_answers(job.answers, labeller, last_s);
  labels.strokes = strokes.strokes;
  labels.strokes.insert(labels.strokes.end(), answers.begin(), answers.end());
  infer_classes(labeller, labels.strokes, subject.areas, labels, report);
}

/// A scan of one part has no more than one name: it tells what the whole is ("body"), not its parts. Infers
/// the classes if there is a face to start from; gives false, and changes nothing, if not.
bool infer_where_one_name_is_all(const Subject& subject, const LabelJob& job, Labels& labels,
                                 LabelReport& report) {
  const Scan& scan = subject.scan;
  const uint8_t only = labels.face_class.front();
  const bool is_one_class =
      std::all_of(labels.face_class.begin(), labels.face_class.end(), [&](uint8_t c) { return c == only; });
  if (!is_one_class || scan.materials.size() > 1 || !subject.surface || !has_picture(scan)) return false;
  labelling::Labeller labeller(*subject.surface, {}, job.leather_share);
  if (!labeller.start().found_face) return false;
  labels.face_class.assign(scan.face_count(), kUnlabelled);
  report.method = "automatic";
  report.rules.clear();
  report.warnings.push_back(
      std::string("names would make every face ") + kClassNames[only] +
      ": inferred from body, colour and texture instead; look at them, and correct them "
      "with --strokes");
  infer_classes(labeller, {}, subject.areas, labels, report);
  return true;
}

void label_by_rules(const Subject& subject, const LabelJob& job, Labels& labels, LabelReport& report) {
  const Scan& scan = subject.scan;
  const bool is_given = !job.rules.empty();
  report.method = is_given ? "rules" : "names";
  const LabelRules rules = read_label_rules(is_given ? job.rules : program_file("assets/rules_by_name.xml"));
  const std::vector<Vec3f> colours =
      rules.use_colour() ? labelling::mean_face_colours(scan) : std::vector<Vec3f>();
  RuleOutcome outcome;
  labels.face_class = apply_rules(rules, scan, colours, outcome);
  report_rules(rules, outcome, subject.areas, is_given, report);
  const size_t undecided = undecided_faces(labels.face_class);
  if (!is_given && undecided == 0 && infer_where_one_name_is_all(subject, job, labels, report)) return;
  if (undecided == 0) return;
  const std::string count = std::to_string(undecided) + " of " + std::to_string(scan.face_count()) + " faces";
  const std::string where = " (material " + undecided_materials(scan, labels.face_class) + ")";
  if (is_given)
    throw InputError(job.rules.string(), "", "no rule takes " + count + where,
                     "add rules, or default=\"...\" to <rules>");
  if (!has_picture(scan))
    throw InputError(
        job.scan.string(), "",
        "names do not tell the class of " + count + where + ", and there is no picture to infer it from",
        "give --rules with a class for them, --faces with finished classes, or --strokes");
  report.method =
      undecided == scan.face_count() ? "automatic" : "names, and automatic where they say nothing";
  report.warnings.push_back("names do not tell the class of " + count + where +
                            ": inferred from body, colour and texture; look at them, and correct them with "
                            "--strokes");
  labelling::Labeller labeller(surface_of(subject, job), {}, job.leather_share);
  infer_classes(labeller, {}, subject.areas, labels, report);
}

/// Writes the class maps, along the picture's borders or the faces'.
void write_maps(const fs::path& folder, const Subject& subject, const LabelJob& job, const Labels& labels,
                LabelReport& report) {
  FaceLabels shown{labels.face_class, labels.confidence};
  std::optional<labelling::TexelLabels> texels;
  std::optional<labelling::SoftBorders> borders;
  if (!subject.surface) {
    report.warnings.push_back("the unit is not known: borders are hard; give --unit");
  } else if (job.refine == RefineBorders::kOn ||
             (job.refine == RefineBorders::kAuto && !labels.confidence.empty())) {
    texels.emplace(*subject.surface, labels.face_class, labels.is_given, job.refine == RefineBorders::kAuto);
    report.texel_borders = texels->summary();
    borders.emplace(*subject.surface, texels->borders(), texels->classes_of_face());
    shown.texels = &*texels;
    shown.unit_cm = subject.surface->unit_cm;
  } else {
    borders.emplace(*subject.surface, labels.face_class);
  }
  if (borders) shown.borders = &*borders;
  for (const std::string& name : write_class_maps(folder, subject.scan, shown))
    report.warnings.push_back("material '" + name + "' has faces without usable UVs: no class map for it");
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
    const nlohmann::json json = read_json(candidate);
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

namespace {

void check_sources(const LabelJob& job) {
  if (!job.rules.empty() + !job.faces.empty() + !job.strokes.empty() + job.automatic > 1)
    throw InputError("", "--rules", "--faces, --strokes and --automatic exclude each other",
                     "give one of them");
  if (!job.answers.empty() && job.strokes.empty() && !job.automatic)
    throw InputError("", "--answer", "answers what --automatic or --strokes asks", "add one of them");
}

Subject subject_of(const Scan& scan, const LabelJob& job) {
  Subject subject{scan, face_areas(scan), {}};
  const std::optional<double> unit_cm =
      job.unit.empty() ? guess_unit(scan).unit_cm : std::optional(unit_cm_of(job.unit));
  if (!unit_cm) return subject;
  expect_upright(scan, *unit_cm, job.up);
  subject.surface.emplace(scan, *unit_cm);
  return subject;
}

void write_strokes(const fs::path& file, const LabelJob& job, const Labels& labels,
                   const std::string& scan_sha256) {
  if (!job.answers.empty())
    write_file_atomically(file, labelling::strokes_xml({scan_sha256, labels.strokes}));
  else if (!job.strokes.empty())
    write_file_atomically(file, read_file(job.strokes));
}

}  // namespace

LabelReport label_scan(const LabelJob& job) {
  check_sources(job);
  AtomicFolder folder(job.output, "regions", {job.scan, job.rules, job.faces, job.strokes, job.truth});
  Scan scan = read_scan(job.scan);
  turn_up(scan, job.up);
  folder.protect(picture_files(scan));
  const Subject subject = subject_of(scan, job);
  LabelReport report;
  report.scan = job.scan.filename().string();
  if (subject.surface) report.unit_cm = subject.surface->unit_cm;
  report.scan_sha256 = sha256_of_file(job.scan);
  Labels labels;
  if (!job.strokes.empty() || job.automatic) {
    label_by_strokes(subject, job, labels, report);
  } else if (job.faces.empty()) {
    label_by_rules(subject, job, labels, report);
  } else {
    report.method = "faces";
    labels.face_class = classes_of_file(job.faces, scan, job);
  }
  const Regions regions{labels.face_class, report.scan_sha256, job.up};
  report_classes(regions.face_class, subject.areas, report);
  if (report.unlabelled.faces > 0)
    report.warnings.push_back(std::to_string(report.unlabelled.faces) +
                              " faces are unlabelled; bake needs all");
  if (!job.truth.empty())
    report.truth =
        compare_with_truth(regions.face_class, classes_of_file(job.truth, scan, job), subject.areas);
  write_regions(folder.path(), regions);
  write_strokes(folder.path() / "strokes.xml", job, labels, report.scan_sha256);
  write_maps(folder.path(), subject, job, labels, report);
  write_previews(folder.path(), scan, labels.face_class, labels.question_of_face, report);
  write_file_atomically(folder.path() / "report.json", json_text(to_json(report), 2) + "\n");
  write_file_atomically(folder.path() / "report.txt", to_text(report));
  folder.commit();
  return report;
}

}  // namespace ohb::commands
