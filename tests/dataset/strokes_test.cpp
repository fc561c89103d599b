#include "dataset/labelling/strokes.h"

#include "tests/support/scan_files.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace labelling;
namespace {

/// A sheet of n x n unit quads in the plane z = 0, facing +Z.
Scan sheet(int n) {
  Scan scan;
  scan.materials.resize(1);
  scan.groups = {"sheet"};
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) scan.positions.push_back({static_cast<float>(x), static_cast<float>(y), 0});
  scan.face_begin = {0};
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      for (int index :
           {y * (n + 1) + x, y * (n + 1) + x + 1, (y + 1) * (n + 1) + x + 1, (y + 1) * (n + 1) + x})
        scan.corners.push_back({static_cast<uint32_t>(index), Corner::kNoUv});
      scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
      scan.face_material.push_back(0);
      scan.face_group.push_back(0);
    }
  return scan;
}

Stroke stroke_of(MaterialClass material_class, double radius_cm, double time_s,
                 std::vector<StrokePoint> points) {
  Stroke stroke;
  stroke.material_class = material_class;
  stroke.radius_cm = radius_cm;
  stroke.time_s = time_s;
  stroke.points = std::move(points);
  return stroke;
}

TEST(Strokes, CoverTheFacesWithinTheirRadiusInCm) {
  const Scan scan = sheet(20);
  for (double unit_cm : {1.0, 10.0}) {
    const FaceGraph graph = face_graph({scan, unit_cm});
    const Stroke stroke =
        stroke_of(kHair, 2.2 * unit_cm, 0, {{5 + 20 * 5, {5.5f, 5.5f, 0}}, {14 + 20 * 5, {14.5f, 5.5f, 0}}});
    const std::vector<uint32_t> faces = faces_of_stroke(stroke, graph, unit_cm);
    size_t expected = 0;
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 20; ++x) {
        const double dx = std::max({0.0, 5.0 - x, x - 14.0}), dy = y - 5.0;
        const bool is_in = dx * dx + dy * dy <= 2.2 * 2.2;
        expected += is_in;
        EXPECT_EQ(std::binary_search(faces.begin(), faces.end(), static_cast<uint32_t>(x + 20 * y)), is_in)
            << x << " " << y;
      }
    EXPECT_EQ(faces.size(), expected);
  }
}

TEST(Strokes, DoNotPaintTheOtherSideOfAThinSheet) {
  Scan scan = sheet(6);
  // The same sheet turned over, 0.1 below, joined at its rim would be a garment: here joined along one side.
  const auto points = static_cast<uint32_t>(scan.positions.size());
  for (uint32_t i = 0; i < points; ++i) {
    Vec3f p = scan.positions[i];
    p.z = p.x == 0 ? 0.0f : -0.1f;
    scan.positions.push_back(p);
  }
  const size_t corners = scan.corners.size(), faces = scan.face_count();
  for (size_t f = 0; f < faces; ++f) {
    for (int c = 3; c >= 0; --c)
      scan.corners.push_back({scan.corners[4 * f + c].position + points, Corner::kNoUv});
    scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
    scan.face_material.push_back(0);
    scan.face_group.push_back(0);
  }
  ASSERT_EQ(scan.corners.size(), 2 * corners);
  const FaceGraph graph = face_graph({scan, 1});
  for (uint32_t f : faces_of_stroke(stroke_of(kSkin, 5, 0, {{7, {1.5f, 1.5f, 0}}}), graph, 1))
    EXPECT_LT(f, 36u);
}

TEST(Strokes, TheLaterOneCountsAndAContradictionIsTold) {
  const Scan scan = sheet(10);
  const FaceGraph graph = face_graph({scan, 1});
  const StrokePoint middle{55, {5.5f, 5.5f, 0}};
  const Stroke skin = stroke_of(kSkin, 1.2, 5, {middle}), hair = stroke_of(kHair, 2.2, 9, {middle});
  for (const std::vector<Stroke>& strokes :
       {std::vector<Stroke>{skin, hair}, std::vector<Stroke>{hair, skin}}) {
    const StrokedFaces stroked = stroked_faces(strokes, graph, 1);
    EXPECT_EQ(stroked.material_class, std::vector<uint8_t>(stroked.face.size(), kHair));
    ASSERT_EQ(stroked.warnings.size(), 1u);
    expect_message(stroked.warnings[0], {"(skin) contradicts stroke", "100 %", "the later one counts"});
  }
  EXPECT_TRUE(stroked_faces({skin, stroke_of(kSkin, 2, 9, {middle})}, graph, 1).warnings.empty());
}

TEST(Strokes, ReadBackWhatWasWritten) {
  const TemporaryFolder folder;
  Strokes strokes;
  strokes.scan_sha256 = "ab";
  strokes.strokes = {stroke_of(kLeather, 1.25, 0.1, {{3, {3.1f, 0.5f, 0}}, {4, {4.7f, 0.3f, 0}}})};
  const Strokes read = read_strokes(write_bytes(folder / "s.xml", strokes_xml(strokes)), sheet(10), 1);
  ASSERT_EQ(read.strokes.size(), 1u);
  EXPECT_EQ(read.scan_sha256, "ab");
  EXPECT_EQ(read.strokes[0].material_class, kLeather);
  EXPECT_EQ(read.strokes[0].radius_cm, 1.25);
  EXPECT_EQ(read.strokes[0].time_s, 0.1);
  ASSERT_EQ(read.strokes[0].points.size(), 2u);
  EXPECT_EQ(read.strokes[0].points[1].face, 4u);
  EXPECT_EQ(read.strokes[0].points[1].at.x, 4.7f);
}

TEST(Strokes, BadOnesAreRefusedInWords) {
  const TemporaryFolder folder;
  const Scan scan = sheet(4);
  const auto error_of = [&](const std::string& content) {
    const auto file = write_bytes(folder / "s.xml", content);
    return input_error_of([&] { read_strokes(file, scan, 1); });
  };
  const auto with_point = [](const std::string& point) {
    return "<strokes schema='1.0'>\n<stroke class='skin' radius_cm='1' time_s='0'>\n" + point +
           "</stroke></strokes>";
  };
  const auto with_stroke = [](const std::string& attributes) {
    return "<strokes schema='1.0'><stroke " + attributes + "><point face='0' at='0,0,0'/></stroke></strokes>";
  };
  expect_message(error_of(with_point("<point face='16' at='1,1,0'/>")),
                 {"stroke 1", "face 16 does not exist", "has 16", "count faces from 0"});
  expect_message(error_of(with_point("<point face='-1' at='1,1,0'/>")), {"line 3", "face"});
  expect_message(error_of(with_point("<point face='0' at='1,1'/>")), {"line 3", "\"1 1\" is no position"});
  expect_message(error_of(with_point("<point face='0' at='1,nan,0'/>")), {"line 3", "is no position"});
  expect_message(error_of(with_point("<point face='0' at='90,0,0'/>")),
                 {"89.0 cm away from its face 0", "is this the scan"});
  expect_message(error_of(with_point("")), {"line 2", "has no point"});
  expect_message(error_of(with_stroke("class='silk' radius_cm='1' time_s='0'")),
                 {"class=\"silk\" is no class", "use skin"});
  expect_message(error_of(with_stroke("class='skin' radius_cm='0' time_s='0'")),
                 {"radius of 0 cm is out of range"});
  expect_message(error_of(with_stroke("class='skin' radius_cm='1000' time_s='0'")), {"radius_cm"});
  expect_message(error_of(with_stroke("class='skin' radius_cm='1'")), {"time_s"});
  expect_message(error_of(with_stroke("class='skin' radius_cm='1' time_s='0' colour='red'")), {"colour"});
  expect_message(error_of("<strokes schema='2.0'/>"), {"schema 2.0 is not known"});
  expect_message(error_of("<strokes schema='1.0'><line/></strokes>"), {"line"});
  EXPECT_TRUE(
      read_strokes(write_bytes(folder / "s.xml", "<strokes schema='1.0'/>"), scan, 1).strokes.empty());
}

TEST(FaceGraph, EdgesJoinSeamsAndBridgesJoinNeighbours) {
  Scan scan = sheet(3);  // 9 faces, 12 shared edges
  // A second sheet 0.3 above the first, and one far away.
  const Scan other = sheet(3);
  for (float z : {0.3f, 50.0f}) {
    const auto base = static_cast<uint32_t>(scan.positions.size());
    for (Vec3f p : other.positions) scan.positions.push_back({p.x, p.y, z});
    for (const Corner& corner : other.corners)
      scan.corners.push_back({corner.position + base, Corner::kNoUv});
    for (size_t f = 1; f < other.face_begin.size(); ++f) {
      scan.face_begin.push_back(scan.face_begin.back() + 4);
      scan.face_material.push_back(0);
      scan.face_group.push_back(0);
    }
  }
  const FaceGraph graph = face_graph({scan, 1});
  EXPECT_EQ(graph.component_count, 3u);
  EXPECT_EQ(graph.edges.size() - graph.bridge_count, 36u);
  EXPECT_GT(graph.bridge_count, 0u);
  double joined_cm2 = 0;
  for (const FaceEdge& edge : graph.edges) {
    EXPECT_LT(edge.a, edge.b);
    EXPECT_LT(edge.b, 18u + 9u * !edge.is_bridge);
    if (!edge.is_bridge) {
      EXPECT_FLOAT_EQ(edge.length_cm, 1);
      EXPECT_FLOAT_EQ(edge.distance_cm, 1);
    } else {
      joined_cm2 += edge.length_cm * kBridgeReach_cm;
    }
  }
  EXPECT_NEAR(joined_cm2, 18, 1e-4);  // both sheets whole: whatever the fineness
}

TEST(FaceGraph, ThreeFacesAtAnEdgeAreJoined) {
  Scan scan = sheet(1);
  scan.positions.insert(scan.positions.end(), {{0, 0, 1}, {1, 0, 1}, {0, 0, -1}, {1, 0, -1}});
  for (uint32_t high : {4u, 6u}) {
    for (uint32_t p : {0u, 1u, high + 1, high}) scan.corners.push_back({p, Corner::kNoUv});
    scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
    scan.face_material.push_back(0);
    scan.face_group.push_back(0);
  }
  const FaceGraph graph = face_graph({scan, 1});
  EXPECT_EQ(graph.non_manifold_edges, 1u);
  EXPECT_EQ(graph.edges.size(), 2u);
}

}  // namespace
}  // namespace ohb
