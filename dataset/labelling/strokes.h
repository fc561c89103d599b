// Strokes: what a user painted on the surface to say which class it is; strokes.xml.
//
//   <strokes schema="1.0" scan_sha256="...">
//     <stroke class="leather" radius_cm="1.5" time_s="12.5">
//       <point face="1043" at="12.1,95.0,8.3"/>
//       <point face="1102" at="13.0,93.2,8.4"/>
//     </stroke>
//   </strokes>
//
// `at` is in the scan's own unit and axes, the radius in cm on the surface, the time in seconds of any clock.
// Where strokes cross, the later one counts.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/labelling/face_graph.h"
#include "dataset/model/regions.h"

namespace ohb::labelling {

struct StrokePoint {
  uint32_t face;
  Vec3f at;  // in the scan's unit and axes
};

struct Stroke {
  MaterialClass material_class = kUnlabelled;
  double radius_cm = 1;
  double time_s = 0;
  std::vector<StrokePoint> points;  // one at least; straight between them
};

struct Strokes {
  std::string scan_sha256;  // of the scan's mesh file; empty: not stated
  std::vector<Stroke> strokes;
};

/// Largest radius of a stroke.
constexpr double kMaxStrokeRadius_cm = 50;

/// Throws InputError: malformed, unknown class or attribute, a radius or time out of range, no points, a face
/// that the scan does not have, a point that is farther than the stroke's radius and its face's size from its
/// face. An empty list is valid.
Strokes read_strokes(const std::filesystem::path& file, const Scan& scan, double unit_cm);
std::string strokes_xml(const Strokes& strokes);

/// Throws InputError with `place` ("stroke 2") for what read_strokes would refuse in one stroke.
void expect_stroke_on_scan(const Stroke& stroke, const Scan& scan, double unit_cm, const std::string& file,
                           const std::string& place);

/// The faces that a stroke covers: those of its points, and those connected with them whose centre is within
/// the radius of its line and which face the same half-space as the point's face. Ascending.
std::vector<uint32_t> faces_of_stroke(const Stroke& stroke, const FaceGraph& graph, double unit_cm);

/// What all strokes together say: the class that each covered face was given last.
struct StrokedFaces {
  std::vector<uint32_t> face;  // ascending
  std::vector<uint8_t> material_class;
  std::vector<std::string> warnings;  // strokes that later ones of other classes cover by more than half
};
StrokedFaces stroked_faces(const std::vector<Stroke>& strokes, const FaceGraph& graph, double unit_cm);

}  // namespace ohb::labelling
