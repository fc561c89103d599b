#include "dataset/commands/label_serve.h"

#include <chrono>
#include <cmath>
#include <istream>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>

#include "dataset/commands/scan_hand_over.h"
#include "dataset/labelling/labeller.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"
#include "dataset/model/scan_unit.h"

namespace ohb::commands {
namespace {

using Json = nlohmann::ordered_json;
constexpr int kConfidenceSteps = 15;

InputError request_error(const std::string& cause, const std::string& mend) {
  return InputError("", "request", cause, mend);
}

const Json& member(const Json& request, const char* name) {
  const auto found = request.find(name);
  if (found == request.end())
    throw request_error(std::string("has no \"") + name + "\"", "see docs/label_files.md");
  return *found;
}

std::string text_of(const Json& request, const char* name) {
  const Json& value = member(request, name);
  if (!value.is_string()) throw request_error(std::string("\"") + name + "\" is no text", "quote it");
  return value.get<std::string>();
}

double number_of(const Json& value, const char* name) {
  if (!value.is_number() || !std::isfinite(value.get<double>()))
    throw request_error(std::string("\"") + name + "\" is no number", "write a finite number");
  return value.get<double>();
}

labelling::StrokePoint point_of(const Json& json) {
  if (!json.is_array() || json.size() != 4 || !json[0].is_number_unsigned() ||
      json[0].get<uint64_t>() > 0xfffffffeu)
    throw request_error("a point is not [face, x, y, z]", "count faces from 0");
  labelling::StrokePoint point{json[0].get<uint32_t>(), {}};
  for (int i = 0; i < 3; ++i)
    point.at[i] = static_cast<float>(number_of(json[static_cast<size_t>(i) + 1], "points"));
  return point;
}

/// [[first, count, value], ...] of the items that differ from `before`; all of them if that is empty.
Json changed_runs(const std::vector<uint8_t>& before, const std::vector<uint8_t>& after) {
  Json runs = Json::array();
  const auto is_changed = [&](size_t i) { return before.empty() || before[i] != after[i]; };
  for (size_t i = 0; i < after.size();) {
    if (!is_changed(i)) {
      ++i;
      continue;
    }
    size_t end = i + 1;
    while (end < after.size() && after[end] == after[i] && is_changed(end)) ++end;
    runs.push_back({i, end - i, after[i]});
    i = end;
  }
  return runs;
}

Scan turned_scan(const LabelServeJob& job) {
  Scan scan = read_scan(job.scan);
  turn_up(scan, job.up);
  return scan;
}

class Session {
 public:
  explicit Session(const LabelServeJob& job)
      : scan_(turned_scan(job)),
        unit_cm_(resolve_unit_cm(scan_, job.unit.empty() ? std::nullopt : std::optional(job.unit))) {
    expect_upright(scan_, unit_cm_, job.up);
    strokes_.scan_sha256 = sha256_of_file(job.scan);
    if (!job.strokes.empty()) {
      const labelling::Strokes given = labelling::read_strokes(job.strokes, scan_, unit_cm_);
      if (!given.scan_sha256.empty() && given.scan_sha256 != strokes_.scan_sha256)
        throw InputError(job.strokes.string(), "", "was painted on another scan",
                         "give the strokes of this scan");
      strokes_.strokes = given.strokes;
    }
    labeller_.emplace(labelling::ScanSurface(scan_, unit_cm_));
  }

  Json hello() {
    Json json{
        {"ready", true}, {"faces", scan_.face_count()}, {"unit_cm", unit_cm_}, {"classes", kClassNames}};
    json.update(solve());
    return json;
  }

  /// Throws InputError and changes nothing for a wrong request.
  Json answer(const Json& request) {
    const std::string what = text_of(request, "do");
    if (what == "stroke") {
      strokes_.strokes.push_back(stroke_of(request));
      return solve();
    }
    if (what == "undo") {
      if (strokes_.strokes.empty()) throw request_error("there is no stroke to undo", "paint one first");
      strokes_.strokes.pop_back();
      return solve();
    }
    if (what == "strokes") {
      strokes_.strokes = strokes_of(request);
      return solve();
    }
    if (what == "mesh") {
      Json json = hand_over_scan(scan_, text_of(request, "folder"));
      json["scan_sha256"] = strokes_.scan_sha256;
      return json;
    }
    if (what == "save") {
      write_file_atomically(text_of(request, "file"), labelling::strokes_xml(strokes_));
      return {{"strokes", strokes_.strokes.size()}};
    }
    throw request_error("\"" + what + "\" is not known", "use stroke, strokes, undo, mesh, save or quit");
  }

 private:
  std::vector<labelling::Stroke> strokes_of(const Json& request) const {
    const Json& list = member(request, "strokes");
    if (!list.is_array()) throw request_error("\"strokes\" is no list", "write one object a stroke");
    std::vector<labelling::Stroke> strokes;
    for (const Json& one : list) {
      if (!one.is_object()) throw request_error("a stroke is no JSON object", "see docs/label_files.md");
      strokes.push_back(stroke_of(one));
      strokes.back().time_s = static_cast<double>(strokes.size() - 1);
    }
    return strokes;
  }

  labelling::Stroke stroke_of(const Json& request) const {
    labelling::Stroke stroke;
    const std::string name = text_of(request, "class");
    stroke.material_class = class_from_name(name);
    if (stroke.material_class == kUnlabelled)
      throw request_error("\"" + name + "\" is no class", "use " + class_list());
    stroke.radius_cm = number_of(member(request, "radius_cm"), "radius_cm");
    // Each is later than the one before: this order is what counts.
    stroke.time_s = strokes_.strokes.empty() ? 0 : strokes_.strokes.back().time_s + 1;
    const Json& points = member(request, "points");
    if (!points.is_array()) throw request_error("\"points\" is no list", "write [[face, x, y, z], ...]");
    for (const Json& point : points) stroke.points.push_back(point_of(point));
    labelling::expect_stroke_on_scan(stroke, scan_, unit_cm_, "", "request");
    return stroke;
  }

  Json solve() {
    const auto start = std::chrono::steady_clock::now();
    const labelling::Labelling labels = labeller_->solve(strokes_.strokes);
    std::vector<uint8_t> confidence;
    for (float c : labels.confidence)
      confidence.push_back(static_cast<uint8_t>(std::lround(c * kConfidenceSteps)));
    Json json{{"strokes", strokes_.strokes.size()},
              {"changed", changed_runs(face_class_, labels.face_class)},
              {"confidence", changed_runs(confidence_, confidence)},
              {"suggested", nullptr},
              {"warnings", labels.warnings}};
    if (labels.suggested) {
      const Vec3f at =
          labeller_->features().graph.centre_cm[labels.suggested->face] / static_cast<float>(unit_cm_);
      json["suggested"] = {{"face", labels.suggested->face},
                           {"at", {at.x, at.y, at.z}},
                           {"now", kClassNames[labels.suggested->now]},
                           {"rival", kClassNames[labels.suggested->rival]},
                           {"area_cm2", labels.suggested->area_cm2}};
    }
    json["questions"] = Json::array();
    for (const labelling::GarmentQuestion& question : labels.questions) {
      const Vec3f at = labelling::stroke_of_answer(*labeller_, question.garment, kFabric).points.front().at;
      json["questions"].push_back({{"id", question.name},
                                   {"now", kClassNames[question.now]},
                                   {"rival", kClassNames[question.rival]},
                                   {"probability", question.probability},
                                   {"face", question.face},
                                   {"at", {at.x, at.y, at.z}},
                                   {"area_cm2", question.area_cm2}});
    }
    face_class_ = labels.face_class;
    confidence_ = std::move(confidence);
    json["seconds"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return json;
  }

  const Scan scan_;
  const double unit_cm_;
  labelling::Strokes strokes_;
  std::optional<labelling::Labeller> labeller_;
  std::vector<uint8_t> face_class_, confidence_;  // as last told
};

/// The next line of at most kMaxRequest_bytes; what is longer is read over and given as one byte more.
bool next_request(std::istream& in, std::string& line) {
  line.clear();
  bool has_any = false;
  for (int c = in.get(); c != std::istream::traits_type::eof(); c = in.get()) {
    has_any = true;
    if (c == '\n') return true;
    if (line.size() <= kMaxRequest_bytes) line += static_cast<char>(c);
  }
  return has_any;
}

std::string line_of(const Json& json) {
  return json_text(json) + "\n";
}

}  // namespace

void serve_labels(const LabelServeJob& job, std::istream& in, std::ostream& out) {
  Session session(job);
  out << line_of(session.hello()) << std::flush;
  for (std::string line; out && next_request(in, line);) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    Json answer;
    try {
      if (line.size() > kMaxRequest_bytes)
        throw request_error("is longer than 16 MiB", "thin its points out");
      const Json request = parse_json<Json>(line, "request");
      if (!request.is_object()) throw request_error("is no JSON object", "write one object a line");
      if (request.contains("id")) answer["id"] = request["id"];
      if (request.value("do", Json()) == "quit") return;
      answer.update(session.answer(request));
    } catch (const InputError& error) {
      answer["error"] = error.what();
    } catch (const TryAgainError& error) {
      answer["error"] = error.what();
    } catch (const std::filesystem::filesystem_error& error) {  // of a name to save under
      answer["error"] = error.what();
    } catch (const std::bad_alloc&) {
      answer["error"] = "not enough memory";
    }
    out << line_of(answer) << std::flush;
  }
}

}  // namespace ohb::commands
