#include "dataset/labelling/strokes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "dataset/model/error.h"
#include "dataset/model/text_lines.h"
#include "dataset/model/xml_document.h"

namespace ohb::labelling {
namespace {

constexpr uint64_t kMaxFace = 0xfffffffeu;
constexpr double kMaxTime_s = 1e12;

Vec3f read_position(const XmlDocument& xml, pugi::xml_node node) {
  std::string text = xml.text(node, "at");
  std::replace(text.begin(), text.end(), ',', ' ');
  std::string_view rest = text;
  Vec3f position;
  int count = 0;
  for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest), ++count) {
    float number = 0;
    if (count == 3 || !parse_float(word, number) || !std::isfinite(number))
      throw xml.error(node, "at=\"" + text + "\" is no position", "write x,y,z in the scan's unit");
    position[count] = number;
  }
  if (count != 3)
    throw xml.error(node, "at=\"" + text + "\" is no position", "write x,y,z in the scan's unit");
  return position;
}

Stroke read_stroke(const XmlDocument& xml, pugi::xml_node node) {
  xml.expect_attributes(node, {"class", "radius_cm", "time_s"});
  xml.expect_children(node, {"point"});
  Stroke stroke;
  const std::string name = xml.text(node, "class");
  stroke.material_class = class_from_name(name);
  if (stroke.material_class == kUnlabelled)
    throw xml.error(node, "class=\"" + name + "\" is no class", "use " + class_list());
  stroke.radius_cm = xml.number(node, "radius_cm", 0, kMaxStrokeRadius_cm);
  stroke.time_s = xml.number(node, "time_s", 0, kMaxTime_s);
  for (const pugi::xml_node& point : node.children("point")) {
    xml.expect_attributes(point, {"face", "at"});
    stroke.points.push_back(
        {static_cast<uint32_t>(xml.count(point, "face", kMaxFace)), read_position(xml, point)});
  }
  if (stroke.points.empty()) throw xml.error(node, "the stroke has no point", "give one <point> or more");
  return stroke;
}

/// Distance from p to the segment ab.
float distance_to_segment(Vec3f p, Vec3f a, Vec3f b) {
  const Vec3f along = b - a;
  const float squared = dot(along, along);
  const float t = squared > 0 ? std::clamp(dot(p - a, along) / squared, 0.0f, 1.0f) : 0.0f;
  return length(p - (a + t * along));
}

float distance_to_line(Vec3f p, const std::vector<Vec3f>& line) {
  float least = length(p - line[0]);
  for (size_t i = 1; i < line.size(); ++i)
    least = std::min(least, distance_to_segment(p, line[i - 1], line[i]));
  return least;
}

}  // namespace

void expect_stroke_on_scan(const Stroke& stroke, const Scan& scan, double unit_cm, const std::string& file,
                           const std::string& place) {
  if (!(stroke.radius_cm > 0 && stroke.radius_cm <= kMaxStrokeRadius_cm))
    throw InputError(file, place, fmt::format("a radius of {} cm is out of range", stroke.radius_cm),
                     fmt::format("give more than 0 and at most {} cm", kMaxStrokeRadius_cm));
  if (stroke.points.empty()) throw InputError(file, place, "has no point", "give one or more");
  for (const StrokePoint& point : stroke.points) {
    if (point.face >= scan.face_count())
      throw InputError(file, place,
                       fmt::format("face {} does not exist, the scan has {}", point.face, scan.face_count()),
                       "count faces from 0 in the order of the scan's file");
    const uint32_t begin = scan.face_begin[point.face], end = scan.face_begin[point.face + 1];
    float nearest = std::numeric_limits<float>::max(), reach = 0;
    for (uint32_t c = begin; c < end; ++c) {
      const Vec3f corner = scan.positions[scan.corners[c].position];
      nearest = std::min(nearest, length(corner - point.at));
      reach = std::max(reach, length(corner - scan.positions[scan.corners[begin].position]));
    }
    const double away_cm = nearest * unit_cm, allowed_cm = stroke.radius_cm + reach * unit_cm;
    if (!(away_cm <= allowed_cm))
      throw InputError(file, place,
                       fmt::format("a point is {:.1f} cm away from its face {}", away_cm, point.face),
                       "is this the scan that the stroke was painted on, in its own unit and axes?");
  }
}

Strokes read_strokes(const std::filesystem::path& file, const Scan& scan, double unit_cm) {
  const XmlDocument xml(file, "strokes");
  xml.expect_attributes(xml.root(), {"schema", "scan_sha256"});
  xml.expect_children(xml.root(), {"stroke"});
  const std::string schema = xml.text(xml.root(), "schema");
  if (schema.rfind("1.", 0) != 0)
    throw xml.error(xml.root(), "schema " + schema + " is not known here (1.x is)", "use a newer version");
  Strokes strokes;
  strokes.scan_sha256 = xml.text_or(xml.root(), "scan_sha256", "");
  for (const pugi::xml_node& node : xml.root().children("stroke")) {
    strokes.strokes.push_back(read_stroke(xml, node));
    expect_stroke_on_scan(strokes.strokes.back(), scan, unit_cm, file.string(),
                          "stroke " + std::to_string(strokes.strokes.size()));
  }
  return strokes;
}

std::string strokes_xml(const Strokes& strokes) {
  pugi::xml_document document;
  pugi::xml_node root = document.append_child("strokes");
  root.append_attribute("schema") = "1.0";
  if (!strokes.scan_sha256.empty()) root.append_attribute("scan_sha256") = strokes.scan_sha256.c_str();
  for (const Stroke& stroke : strokes.strokes) {
    pugi::xml_node node = root.append_child("stroke");
    node.append_attribute("class") = kClassNames[stroke.material_class];
    node.append_attribute("radius_cm") = shortest(stroke.radius_cm).c_str();
    node.append_attribute("time_s") = shortest(stroke.time_s).c_str();
    for (const StrokePoint& point : stroke.points) {
      pugi::xml_node child = node.append_child("point");
      child.append_attribute("face") = point.face;
      child.append_attribute("at") =
          (shortest(point.at.x) + "," + shortest(point.at.y) + "," + shortest(point.at.z)).c_str();
    }
  }
  return xml_text(document);
}

std::vector<uint32_t> faces_of_stroke(const Stroke& stroke, const FaceGraph& graph, double unit_cm) {
  std::vector<Vec3f> line;
  for (const StrokePoint& point : stroke.points) line.push_back(point.at * static_cast<float>(unit_cm));
  std::vector<uint32_t> faces;
  std::vector<bool> is_in(graph.size(), false);
  for (const StrokePoint& point : stroke.points) {
    if (is_in[point.face]) continue;
    is_in[point.face] = true;
    const Vec3f facing = graph.normal[point.face];
    size_t next = faces.size();
    for (faces.push_back(point.face); next < faces.size(); ++next)
      for (uint32_t n = graph.first_neighbour[faces[next]]; n < graph.first_neighbour[faces[next] + 1]; ++n) {
        const FaceNeighbour& to = graph.neighbours[n];
        if (is_in[to.face] || graph.edges[to.edge].is_bridge || dot(graph.normal[to.face], facing) < 0)
          continue;
        if (distance_to_line(graph.centre_cm[to.face], line) > stroke.radius_cm) continue;
        is_in[to.face] = true;
        faces.push_back(to.face);
      }
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

StrokedFaces stroked_faces(const std::vector<Stroke>& strokes, const FaceGraph& graph, double unit_cm) {
  std::vector<size_t> order(strokes.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t l, size_t r) { return strokes[l].time_s < strokes[r].time_s; });
  std::vector<int> last(graph.size(), -1);
  std::vector<std::vector<uint32_t>> covered(strokes.size());
  for (size_t s : order) {
    covered[s] = faces_of_stroke(strokes[s], graph, unit_cm);
    for (uint32_t f : covered[s]) last[f] = static_cast<int>(s);
  }
  StrokedFaces result;
  for (size_t s = 0; s < strokes.size(); ++s) {
    double area = 0, lost = 0;
    int by = -1;
    for (uint32_t f : covered[s]) {
      const double a = double(graph.area_cm2[f]) + 1e-12;
      area += a;
      if (strokes[last[f]].material_class == strokes[s].material_class) continue;
      lost += a;
      by = last[f];
    }
    if (lost > 0.5 * area)
      result.warnings.push_back(
          fmt::format("stroke {} ({}) contradicts stroke {} ({}), which is later and covers {:.0f} % of it: "
                      "the later one counts",
                      s + 1, kClassNames[strokes[s].material_class], by + 1,
                      kClassNames[strokes[by].material_class], 100 * lost / area));
  }
  for (uint32_t f = 0; f < graph.size(); ++f)
    if (last[f] >= 0) {
      result.face.push_back(f);
      result.material_class.push_back(strokes[last[f]].material_class);
    }
  return result;
}

}  // namespace ohb::labelling
