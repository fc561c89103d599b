#include "dataset/commands/inspect.h"

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "dataset/commands/uv_layout.h"
#include "dataset/model/scan_unit.h"
#include "tests/support/scan_files.h"
#include "tests/support/shared_data.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace commands;
namespace {

InspectReport inspect_text_of(const std::string& obj, const std::optional<std::string>& unit = "cm") {
  const TemporaryFolder folder;
  return inspect_scan(read_scan(write_bytes(folder / "scan.obj", obj)), unit);
}

bool warns(const InspectReport& report, const std::string& part) {
  for (const Warning& warning : report.warnings)
    if (warning.what.find(part) != std::string::npos) return true;
  return false;
}

TEST(Inspect, CountsEachFault) {
  const InspectReport report = inspect_text_of(
      "v 0 0 0\nv 100 0 0\nv 100 100 0\nv 0 100 0\nv 50 50 80\nv 7 7 7\nv 200 0 0\nv 300 0 0\nv 300 100 0\n"
      "vt .1 .1\nvt .9 .1\nvt .9 .9\nvt .1 .9\nvt 2.5 2.5\nvt 2.9 2.5\nvt 2.5 2.9\n"
      "f 1/1 2/2 3/3\n"  // 1
      "f 1/1 3/3 4/4\n"  // 2, one sheet with 1
      "f 3/3 2/2 1/1\n"  // 3, repeats 1, mirrored in UV
      "f 1/1 3/3 5/4\n"  // 4, third face at edge 1-3 (with 3: fourth)
      "f 1/1 1/1 2/2\n"  // 5, a vertex twice
      "f 7/5 8/6 9/7\n"  // 6, on its own, in tile 1023
      "f 7 8 9\n");      // 7, repeats 6, without UVs, wound the same way
  EXPECT_EQ(report.faces, 7u);
  EXPECT_EQ(report.unused_vertices, 1u);
  EXPECT_EQ(report.duplicate_faces, 2u);
  EXPECT_EQ(report.repeated_vertex_faces, 1u);
  EXPECT_EQ(report.zero_area_faces, 1u);
  EXPECT_EQ(report.non_manifold_edges, 2u);  // 1-2: faces 1, 3, 5 twice; 1-3: faces 1, 2, 3, 4
  EXPECT_EQ(report.inconsistent_edges, 3u);  // faces 6 and 7
  EXPECT_EQ(report.border_edges, 4u);
  EXPECT_EQ(report.components, 2u);
  const UvLayout& uv = report.materials.at(0).uv;
  EXPECT_EQ(uv.faces_without_uv, 1u);
  EXPECT_EQ(uv.zero_area_faces, 1u);
  EXPECT_EQ(uv.faces_outside, 1u);
  EXPECT_EQ(uv.tiles, (std::vector<int>{1001, 1023}));
  EXPECT_TRUE(warns(report, "no diffuse picture"));
  EXPECT_TRUE(warns(report, "UDIM"));
  for (const Warning& warning : report.warnings) EXPECT_FALSE(warning.mend.empty()) << warning.what;
  const auto json = nlohmann::json::parse(inspect_json(report).dump());
  EXPECT_EQ(json["duplicate_faces"], 2);
  EXPECT_EQ(json["warnings"].size(), report.warnings.size());
  EXPECT_NE(inspect_text(report).find("2 non-manifold edges"), std::string::npos);
}

TEST(Inspect, UnitIsAskedForAndNeverGuessedForBusts) {
  const std::string bust = "v 0 0 0\nv 20 0 0\nv 0 32 0\nf 1 2 3\n";
  EXPECT_FALSE(inspect_text_of(bust, std::nullopt).unit.unit_cm.has_value());
  EXPECT_TRUE(warns(inspect_text_of(bust, std::nullopt), "32"));
  EXPECT_EQ(inspect_text_of(bust, "inch").unit.unit_cm, 2.54);
  EXPECT_TRUE(warns(inspect_text_of(bust, "m"), "3200 cm high"));
}

/// A box of that size, in cm, with its corner at the origin.
std::string box(double x, double y, double z) {
  std::string text;
  for (int i = 0; i < 8; ++i) {
    char line[96];
    std::snprintf(line, sizeof line, "v %g %g %g\n", i & 1 ? x : 0, i & 2 ? y : 0, i & 4 ? z : 0);
    text += line;
  }
  return text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
}

Scan scan_of(const std::string& obj) {
  const TemporaryFolder folder;
  return read_scan(write_bytes(folder / "scan.obj", obj));
}

TEST(ScanUnit, APersonThatLiesIsNoticedWhateverTellsTheUnit) {
  for (const auto& [text, unit] : {std::pair<std::string, const char*>(box(0.5, 0.3, 1.7), "m"),
                                   {box(1.7, 0.3, 0.5), "m"},
                                   {box(500, 300, 1700), "mm"}}) {
    EXPECT_TRUE(warns(inspect_text_of(text, unit), "it lies")) << unit;
    EXPECT_TRUE(warns(inspect_text_of(text, std::nullopt), "it lies")) << unit;
    EXPECT_FALSE(inspect_text_of(text, std::nullopt).unit.unit_cm.has_value());
    const Scan scan = scan_of(text);
    expect_message(input_error_of([&] { expect_upright(scan, unit_cm_of(unit), ""); }),
                   {"scan.obj", "it lies", "--up z", "--up y"});
    EXPECT_NO_THROW(expect_upright(scan, unit_cm_of(unit), "y")) << "it is meant";
  }
  Scan stated = scan_of(box(0.5, 0.3, 1.7));
  stated.stated_unit_cm = 100;
  EXPECT_EQ(guess_unit(stated).unit_cm, 100);
  EXPECT_FALSE(lying_reason(stated, 100).empty());
  turn_up(stated, "z");
  EXPECT_TRUE(lying_reason(stated, 100).empty());
  EXPECT_EQ(guess_unit(stated).unit_cm, 100);
}

TEST(ScanUnit, PartsAndObjectsAreNotCalledLying) {
  // Shoes, a hand, a head, a chair-like thing, spread arms, a bust with spread arms.
  for (const auto& [text, unit] : {std::pair<std::string, const char*>(box(25, 12, 30), "cm"),
                                   {box(9, 20, 4), "cm"},
                                   {box(18, 28, 22), "cm"},
                                   {box(60, 90, 60), "cm"},
                                   {box(175, 170, 30), "cm"}}) {
    EXPECT_FALSE(warns(inspect_text_of(text, unit), "it lies")) << text;
    EXPECT_FALSE(warns(inspect_text_of(text, std::nullopt), "it lies")) << text;
  }
  EXPECT_TRUE(warns(inspect_text_of(box(25, 12, 30), std::nullopt), "a part of a person, or an object"));
  Scan shoe = scan_of(box(0.2, 0.1, 0.3));
  shoe.stated_unit_cm = 100;
  expect_message(guess_unit(shoe).reason, {"10 cm high", "a part of a person, or an object"});
}

TEST(ScanUnit, FeetAreAUnitOfStandingPeopleOnly) {
  EXPECT_EQ(inspect_text_of(box(1.64, 5.577, 0.98), std::nullopt).unit.unit_cm, 30.48);
  EXPECT_FALSE(inspect_text_of(box(11, 5.5, 9), std::nullopt).unit.unit_cm.has_value()) << "a boot in inches";
  EXPECT_EQ(inspect_text_of(box(1, 1, 1), "foot").unit.unit_cm, 30.48);
}

TEST(ScanUnit, TurnsAreProperAndBringTheAxisUp) {
  for (const char* up : {"x", "y", "z", "-x", "-y", "-z"}) {
    Scan scan;
    const std::string axis = up;
    Vec3f along;
    (axis.back() == 'x' ? along.x : axis.back() == 'y' ? along.y : along.z) = axis.size() == 2 ? -1.0f : 1.0f;
    scan.positions = {along, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    turn_up(scan, up);
    EXPECT_EQ(scan.positions[0].y, 1) << up;
    EXPECT_EQ(dot(cross(scan.positions[1], scan.positions[2]), scan.positions[3]), 1) << up << ": mirrored";
  }
  Scan blender;
  blender.positions = {{0, -1, 0}};
  turn_up(blender, "z");
  EXPECT_EQ(blender.positions[0].z, 1) << "people face -Y in Blender";
  Scan scan;
  expect_message(input_error_of([&] { turn_up(scan, "w"); }), {"--up", "'w' is no axis"});
}

TEST(ScanUnit, FeetTellWhereAPersonFaces) {
  // A body, and shoes at its lower end that reach forward, backward or aside.
  const auto person = [](float x0, float x1, float z0, float z1) {
    Scan scan = scan_of(box(40, 170, 30));
    const auto first = static_cast<uint32_t>(scan.positions.size());
    for (int layer = 0; layer < 5; ++layer)
      for (const Vec3f& p : {Vec3f{x0, 0, z0}, {x1, 0, z0}, {x1, 0, z1}, {x0, 0, z1}}) {
        const float shrunk = layer < 1 ? 1.0f : 0.1f;  // sole, then the shin above it
        scan.positions.push_back(
            {20 + (p.x - 20) * shrunk, 4.0f * static_cast<float>(layer), 15 + (p.z - 15) * shrunk});
      }
    scan.face_begin.pop_back();
    for (uint32_t layer = 0; layer < 5; ++layer) {
      scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
      for (uint32_t i = 0; i < 4; ++i) scan.corners.push_back({first + 4 * layer + i});
      scan.face_material.push_back(0);
      scan.face_group.push_back(0);
    }
    scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
    return facing_elsewhere(scan);
  };
  EXPECT_EQ(person(10, 30, 10, 60), "");
  EXPECT_EQ(person(10, 30, -30, 20), "-Z");
  EXPECT_EQ(person(15, 65, 5, 25), "+X");
  EXPECT_EQ(person(-25, 25, 5, 25), "-X");
  EXPECT_EQ(facing_elsewhere(scan_of(box(40, 170, 30))), "");
}

/// Cards that all show the whole picture: the measure is estimated, in bounded time.
TEST(UvLayout, OverlappingCardsAreMeasuredInSeconds) {
  std::string text = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
  for (int i = 0; i < 2000; ++i) {
    for (const char* corner : {"0 0", "1 0", "1 1", "0 1"})
      text += "v " + std::string(corner) + " " + std::to_string(i) + "\n";
    text += "f -4/1 -3/2 -2/3 -1/4\n";
  }
  const auto start = std::chrono::steady_clock::now();
  const InspectReport report = inspect_text_of(text);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60)) << "2 s on a quiet machine";
  const UvLayout& uv = report.materials.at(0).uv;
  EXPECT_TRUE(uv.is_measured);
  EXPECT_LT(uv.grid_px, 2048);
  EXPECT_EQ(uv.coverage, 1);
  EXPECT_EQ(uv.overlap_share, 1);
  EXPECT_NE(inspect_text(report).find("estimated at"), std::string::npos);
}

TEST(UvLayout, OverlapCoverageAndFlips) {
  // Two squares without a common vertex: [0,.5]^2 and, mirrored, [.25,.75] x [0,.5].
  const InspectReport report = inspect_text_of(
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 5 0 0\nv 6 0 0\nv 6 1 0\nv 5 1 0\n"
      "vt 0 0\nvt .5 0\nvt .5 .5\nvt 0 .5\nvt .75 0\nvt .25 0\nvt .25 .5\nvt .75 .5\n"
      "f 1/1 2/2 3/3 4/4\nf 5/5 6/6 7/7 8/8\n");
  const UvLayout& uv = report.materials.at(0).uv;
  EXPECT_NEAR(uv.coverage, 0.375, 1e-9);
  EXPECT_NEAR(uv.overlap_share, 0.125 / 0.375, 1e-9);
  EXPECT_NEAR(uv.flipped_share, 0.5, 1e-9);
}

TEST(UvLayout, NeighboursNeverShareATexelAndLeaveNone) {
  // A jittered grid over the whole tile, inner vertices on texel centres half of the time.
  std::mt19937 random(9);
  const int n = 12, size = 64;
  std::string text;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const bool inner = i > 0 && i < n && j > 0 && j < n;
      const auto place = [&](int k) {
        const double centre = (std::floor(double(k) / n * size) + 0.5) / size;
        return inner ? (random() % 2 ? centre : double(k) / n + (random() % 100 / 99.0 - 0.5) * 0.4 / n)
                     : double(k) / n;
      };
      char line[96];
      std::snprintf(line, sizeof line, "v %d %d 0\nvt %.9g %.9g\n", i, j, place(i), place(j));
      text += line;
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i + 1, b = a + 1, c = b + n + 1, d = c - 1;
      char line[192];
      std::snprintf(line, sizeof line, "f %d/%d %d/%d %d/%d\nf %d/%d %d/%d %d/%d\n", a, a, b, b, c, c, a, a,
                    c, c, d, d);
      text += line;
    }
  const TemporaryFolder folder;
  const Scan scan = read_scan(write_bytes(folder / "grid.obj", text));
  const auto triangles = triangulate(scan);
  size_t covered = 0;
  for (const ScanTriangle& triangle : triangles) {  // each alone
    const UvRaster one = rasterise_uvs(scan, {triangle}, mesh_topology(scan), 0, {size, size});
    covered += one.covered;
  }
  EXPECT_EQ(covered, static_cast<size_t>(size) * size);
  const UvRaster all = rasterise_uvs(scan, triangles, mesh_topology(scan), 0, {size, size});
  EXPECT_EQ(all.covered, static_cast<size_t>(size) * size);
}

/// The normal map of a smooth random height field, 8-bit, green up (OpenGL) or down.
Image normal_map(bool opengl, float noise = 0) {
  const int size = 128;
  std::mt19937 random(4);
  std::uniform_real_distribution<float> unit(-1, 1);
  Image image(size, size, 3);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const float u = (x + 0.5f) / size, v = 1 - (y + 0.5f) / size;
      // h = a sin(9u + 5v) + b cos(7u - 12v): slopes of both signs, coupled in u and v.
      const float p = 0.05f * 9 * std::cos(9 * u + 5 * v) - 0.04f * 7 * std::sin(7 * u - 12 * v);
      const float q = 0.05f * 5 * std::cos(9 * u + 5 * v) + 0.04f * 12 * std::sin(7 * u - 12 * v);
      const Vec3f n = normalised({-p + noise * unit(random), -q + noise * unit(random), 1});
      const float rgb[3] = {n.x, opengl ? n.y : -n.y, n.z};
      for (int c = 0; c < 3; ++c) image.pixel(x, y)[c] = std::round((rgb[c] + 1) / 2 * 255) / 255;
    }
  return image;
}

TEST(NormalConvention, BothSignsFlatAndNoise) {
  const std::vector<uint32_t> region(128 * 128, 0);
  const NormalConventionResult gl = detect_normal_convention(normal_map(true), region);
  const NormalConventionResult dx = detect_normal_convention(normal_map(false), region);
  EXPECT_EQ(gl.convention, NormalConvention::kOpenGl);
  EXPECT_EQ(dx.convention, NormalConvention::kDirectX);
  EXPECT_GT(gl.ratio, 10);
  EXPECT_GT(dx.ratio, 10);
  Image flat(128, 128, 3);
  for (size_t i = 0; i < flat.values.size(); ++i) flat.values[i] = i % 3 == 2 ? 1.0f : 128 / 255.0f;
  EXPECT_EQ(detect_normal_convention(flat, region).convention, NormalConvention::kFlat);
  EXPECT_EQ(detect_normal_convention(normal_map(true, 3.0f), region).convention, NormalConvention::kUnclear);
  EXPECT_EQ(
      detect_normal_convention(normal_map(true), std::vector<uint32_t>(128 * 128, kNoRegion)).convention,
      NormalConvention::kUnclear);
}

TEST(NormalConvention, ChartsDoNotMixAtTheirSeams) {
  // Stripes of charts two texels wide: nothing is left to measure, rather than something wrong.
  std::vector<uint32_t> region(128 * 128);
  for (size_t i = 0; i < region.size(); ++i) region[i] = static_cast<uint32_t>(i % 128 / 2);
  EXPECT_EQ(detect_normal_convention(normal_map(true), region).texels, 0u);
}

TEST(Inspect, EveryHumanAndTheHead) {
  OHB_SHARED_DATA_OR_SKIP(humans, "humans");
  for (const std::filesystem::path& file : objs_below(humans)) {
    SCOPED_TRACE(file.string());
    const InspectReport report = inspect_scan(read_scan(file), std::nullopt);
    EXPECT_EQ(report.unit.unit_cm, 1.0);
    const Vec3f extent = report.bounds.high - report.bounds.low;
    EXPECT_GT(extent.y, 155);
    EXPECT_LT(extent.y, 192);
    const bool is_atlas = file.stem().string().find("_scan") != std::string::npos;
    EXPECT_EQ(report.materials.size() == 1, is_atlas);
    if (is_atlas) {
      EXPECT_LT(report.materials[0].uv.overlap_share, 0.001);
      EXPECT_GT(report.materials[0].uv.coverage, 0.3);
    }
    for (const MaterialReport& material : report.materials) {
      const bool is_card = material.name == "brows" || material.name == "lashes";
      EXPECT_TRUE(!is_card || material.pictures.at(0).transparent_share > 0.2);
      for (const PictureReport& picture : material.pictures)
        EXPECT_NE(picture.convention.convention, NormalConvention::kDirectX);
    }
  }
  const auto heads = objs_below(shared_data("scans"));
  for (const std::filesystem::path& file : heads)
    EXPECT_FALSE(inspect_scan(read_scan(file), std::nullopt).unit.unit_cm.has_value());
}

}  // namespace
}  // namespace ohb
