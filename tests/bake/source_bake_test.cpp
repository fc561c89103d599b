// A high-resolution source onto a low mesh: analytic surfaces, invariants and the ways in which it can fail.
#include "bake/source_bake.h"

#include <tbb/global_control.h>

#include <cmath>
#include <random>

#include "bake/bake.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/colour.h"
#include "tests/bake/test_scans.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace bake;
using namespace surface;
namespace {

constexpr MaterialTable kTable = {
    {{0.184f, 0.4f, 0.08f}, {0.239f, 0.5f, 0}, {0.263f, 0.85f, 0}, {0.224f, 0.25f, 0}}};
constexpr float kPi = 3.14159265f;

float degrees_between(Vec3f a, Vec3f b) {
  return std::atan2(length(cross(a, b)), dot(a, b)) * 180 / kPi;
}

Vec3f pixel3(const Image& image, int x, int row) {
  const float* const p = image.pixel(x, row);
  return {p[0], p[1], p[2]};
}

/// The maps of a low mesh of one set, with what they were made from.
struct Baked {
  TexelCoverage coverage;
  std::vector<UvTriangle> uvs;
  std::unique_ptr<MeshFrames> frames;
  SourceBake bake;
  SourceMaps maps;
};

Baked bake_maps(const Model& low, const Model& high, int size_px, float reach_cm) {
  Baked baked;
  std::vector<uint32_t> index;
  for (const ModelTriangle& triangle : low.triangles) {
    index.push_back(static_cast<uint32_t>(index.size()));
    baked.uvs.push_back({{low.uvs[triangle.uv[0]], low.uvs[triangle.uv[1]], low.uvs[triangle.uv[2]]}});
  }
  baked.coverage = cover_texels(baked.uvs, size_px, size_px);
  const auto surface = std::make_shared<const SourceSurface>(scan_of_model(high, "high.obj"), 1,
                                                             Vec3f{0, 0, 0}, std::vector<GreenChannel>{});
  baked.frames = std::make_unique<MeshFrames>(frames_of(low));
  baked.bake.surface = surface;
  baked.bake.frames = baked.frames.get();
  baked.bake.outward_cm = baked.bake.inward_cm = reach_cm;
  baked.bake.wants_object_normals = true;
  baked.maps = bake_from_source(low, index, baked.uvs, baked.coverage, baked.bake);
  return baked;
}

/// Calls visit(x, row, point of the low mesh, its interpolated frame) for each texel whose centre is covered.
struct LowPoint {
  Vec3f position, normal, tangent;
  float sign;
};
template <typename Visit>
void for_each_texel(const Model& low, const Baked& baked, const Visit& visit) {
  const int size = baked.coverage.width_px;
  for (int row = 0; row < size; ++row)
    for (int x = 0; x < size; ++x) {
      const uint32_t owner = baked.coverage.owner_of(x, row);
      if (owner == TexelCoverage::kNone) continue;
      const NearestPoint near =
          nearest_point_of_texel(to_texel_space(baked.uvs[owner], size, size), size, size, x, row);
      LowPoint point{{}, {}, {}, baked.frames->tangents[3 * owner].sign};
      for (int c = 0; c < 3; ++c) {
        const float w = static_cast<float>(near.weights[c]);
        point.position += w * low.positions_cm[low.triangles[owner].position[c]];
        point.normal += w * baked.frames->normals[low.triangles[owner].position[c]];
        point.tangent += w * baked.frames->tangents[3 * owner + c].tangent;
      }
      visit(x, row, point);
    }
}

TEST(SourceBake, TangentSpaceIsTheExactInverseOfTheDecode) {
  std::mt19937 random(3);
  std::normal_distribution<float> any;
  const auto vector = [&] { return Vec3f{any(random), any(random), any(random)}; };
  for (int i = 0; i < 1000; ++i) {
    const Vec3f t = vector(), n = vector(), direction = normalised(vector());
    const float sign = i % 2 ? 1.0f : -1.0f;
    if (length(cross(t, n)) < 0.1f) continue;
    const Vec3f c = to_tangent_space(direction, t, n, sign);
    const Vec3f decoded = normalised(c.x * t + c.y * sign * cross(n, t) + c.z * n);
    EXPECT_LT(length(decoded - direction), 2e-5f);
  }
  EXPECT_EQ(to_tangent_space({1, 0, 0}, {0, 0, 0}, {0, 0, 1}, 1).z, 1);
}

/// sphere_model with one position at each pole, so that the normal there is the sphere's.
Model closed_sphere(float radius_cm, int columns) {
  Model model = sphere_model(radius_cm, columns, TextureSet());
  const uint32_t row = static_cast<uint32_t>(columns) + 1, last = static_cast<uint32_t>(columns) / 2 * row;
  for (ModelTriangle& triangle : model.triangles)
    for (uint32_t& p : triangle.position) p = p < row ? 0 : p >= last ? last : p;
  return model;
}

TEST(SourceBake, FineSphereOntoACoarseOne) {
  const float radius = 50;
  const Model low = closed_sphere(radius, 24), high = closed_sphere(radius, 480);
  const Vec3f centre{0, radius, 0};
  const Baked baked = bake_maps(low, high, 128, 3);
  size_t texels = 0;
  for_each_texel(low, baked, [&](int x, int row, const LowPoint& point) {
    ASSERT_EQ(baked.maps.results[row * 128 + x], RayResult::kHit);
    // Along the direction d from p: |p + h d - centre| = radius.
    const Vec3f d = normalised(point.normal), p = point.position - centre;
    const float b = dot(p, d), height = -b + std::sqrt(b * b - dot(p, p) + radius * radius);
    EXPECT_NEAR(*baked.maps.height.pixel(x, row), height,
                2.2e-3f);  // the sagitta of the fine sphere's diagonals
    const Vec3f expected = normalised(p + height * d);
    EXPECT_LT(degrees_between(pixel3(baked.maps.object_normal, x, row), expected), 0.1f);
    const Vec3f c = pixel3(baked.maps.normal, x, row);
    const Vec3f decoded =
        c.x * point.tangent + c.y * point.sign * cross(point.normal, point.tangent) + c.z * point.normal;
    EXPECT_LT(degrees_between(decoded, expected), 0.1f);
    EXPECT_NEAR(*baked.maps.displacement.pixel(x, row), (centre + radius * expected).z, 3e-3f);
    ++texels;
  });
  EXPECT_GT(texels, 128u * 128u * 9 / 10);
}

TEST(SourceBake, SineHeightsOntoAPlane) {
  const auto wave = [](float x, float y) { return 0.3f * std::sin(0.8f * x) * std::cos(0.5f * y); };
  const Model low = height_field(3, 20, [](float, float) { return 0.0f; });
  const Model high = height_field(400, 20, wave);
  const Baked baked = bake_maps(low, high, 64, 1);
  for_each_texel(low, baked, [&](int x, int row, const LowPoint& point) {
    const Vec3f p = point.position;
    EXPECT_NEAR(*baked.maps.height.pixel(x, row), wave(p.x, p.y), 1e-3f);
    EXPECT_NEAR(*baked.maps.displacement.pixel(x, row), wave(p.x, p.y), 1e-3f);
    const float by_x = 0.3f * 0.8f * std::cos(0.8f * p.x) * std::cos(0.5f * p.y);
    const float by_y = -0.3f * 0.5f * std::sin(0.8f * p.x) * std::sin(0.5f * p.y);
    // The plane's u runs along x and its v along y, so its tangent space is the model's.
    EXPECT_LT(degrees_between(pixel3(baked.maps.normal, x, row), {-by_x, -by_y, 1}), 0.3f);
  });
}

/// The same surface with other UVs: u, v of [0,1]^2 turned by quarters and mirrored.
Model with_turned_uvs(Model model, int quarter_turns, bool mirrored) {
  for (Vec2f& uv : model.uvs) {
    for (int i = 0; i < quarter_turns; ++i) uv = {1 - uv.y, uv.x};
    if (mirrored) uv.x = 1 - uv.x;
  }
  return model;
}

TEST(SourceBake, ObjectNormalsDoNotKnowHowTheChartLies) {
  const auto wave = [](float x, float y) { return 0.3f * std::sin(0.8f * x + 0.2f * y); };
  const Model high = height_field(200, 20, wave);
  const Model flat = height_field(4, 20, [](float x, float) { return 0.05f * x; });
  constexpr int kSize = 32;
  const Baked straight = bake_maps(flat, high, kSize, 3);
  for (int turns = 0; turns < 4; ++turns)
    for (bool mirrored : {false, true}) {
      const Baked turned = bake_maps(with_turned_uvs(flat, turns, mirrored), high, kSize, 3);
      for (int row = 0; row < kSize; ++row)
        for (int x = 0; x < kSize; ++x) {
          int i = x, j = kSize - 1 - row;  // v up
          for (int k = 0; k < turns; ++k) {
            const int old = i;
            i = kSize - 1 - j;
            j = old;
          }
          if (mirrored) i = kSize - 1 - i;
          const Vec3f a = pixel3(straight.maps.object_normal, x, row);
          const Vec3f b = pixel3(turned.maps.object_normal, i, kSize - 1 - j);
          ASSERT_LT(length(a - b), 1e-4f) << turns << mirrored << x << " " << row;
          EXPECT_NEAR(*straight.maps.height.pixel(x, row), *turned.maps.height.pixel(i, kSize - 1 - j),
                      1e-4f);
        }
    }
}

TEST(SourceBake, AThinSheetGivesItsNearSideOnly) {
  const auto sheet = [](float z) { return height_field(20, 10, [z](float, float) { return z; }); };
  // A sheet 1 mm thick, another one 1 cm behind it, as a leg behind a leg; the low mesh before and inside it.
  const Model high =
      joined(joined(sheet(0), turned_over(sheet(-0.1f))), joined(sheet(-1.1f), turned_over(sheet(-1.2f))));
  for (float z : {0.3f, 0.02f, 0.0f, -0.04f}) {
    const Baked baked = bake_maps(sheet(z), high, 32, 2);
    for (int i = 0; i < 32 * 32; ++i) {
      ASSERT_EQ(baked.maps.results[i], RayResult::kHit) << z;
      EXPECT_NEAR(baked.maps.displacement.values[i], 0, 1e-5f) << z;
    }
  }
  // From behind, the other side.
  const Baked behind = bake_maps(turned_over(sheet(-0.2f)), high, 32, 2);
  for (float value : behind.maps.displacement.values) EXPECT_NEAR(value, -0.1f, 1e-5f);
}

TEST(SourceBake, TheFarLegIsNeverTaken) {
  // The near leg has a hole where the far one (facing the same way, within the reach) shows through.
  const Model far_leg = joined(height_field(20, 10, [](float, float) { return -1.0f; }),
                               turned_over(height_field(20, 10, [](float, float) { return -1.5f; })));
  Model near_leg = joined(height_field(20, 10, [](float, float) { return 0.0f; }),
                          turned_over(height_field(20, 10, [](float, float) { return -0.5f; })));
  std::vector<ModelTriangle> kept;
  for (const ModelTriangle& triangle : near_leg.triangles) {
    const Vec3f p = near_leg.positions_cm[triangle.position[0]];
    if (!(p.z == 0 && p.x >= 2 && p.x < 7 && p.y >= 2 && p.y < 7)) kept.push_back(triangle);
  }
  near_leg.triangles = kept;
  const Baked baked =
      bake_maps(height_field(1, 10, [](float, float) { return 0.1f; }), joined(near_leg, far_leg), 64, 2);
  size_t back_faces = 0;
  for (int i = 0; i < 64 * 64; ++i) {
    if (baked.maps.results[i] == RayResult::kHit || baked.maps.results[i] == RayResult::kNearest) {
      EXPECT_NEAR(baked.maps.displacement.values[i], 0, 1e-5f);
    }
    back_faces += baked.maps.results[i] == RayResult::kBackFace;
  }
  EXPECT_GT(back_faces, 50u);  // the middle of the hole, where the rim is out of reach
}

TEST(SourceBake, DoubleSidedSheetsAreNotTheirOwnBackFace) {
  const Model sheet = height_field(8, 10, [](float x, float y) { return 0.1f * std::sin(x) + 0.05f * y; });
  const Baked baked = bake_maps(sheet, joined(turned_over(sheet), sheet), 32, 1);
  for (int i = 0; i < 32 * 32; ++i) {
    EXPECT_EQ(baked.maps.results[i], RayResult::kHit);
    EXPECT_NEAR(baked.maps.height.values[i], 0, 1e-4f);
  }
}

/// A bumpy sheet with a picture and a normal map, as scan and regions.
struct PicturedSheet {
  TemporaryFolder folder;
  Scan scan;
  Regions regions;
  explicit PicturedSheet(int size_px) {
    scan = scan_of_model(
        height_field(12, 150, [](float x, float y) { return 3 * std::sin(0.05f * x + 0.03f * y); }),
        "sheet.obj");
    regions = one_class(scan);
    Image colour(size_px, size_px, 3), normal(size_px, size_px, 3);
    std::mt19937 random(9);
    std::uniform_real_distribution<float> any(0, 1);
    for (float& value : colour.values) value = any(random);
    for (int i = 0; i < size_px * size_px; ++i) {
      const Vec3f n = normalised({any(random) - 0.5f, any(random) - 0.5f, 1});
      for (int c = 0; c < 3; ++c) normal.values[3 * i + c] = n[c];
    }
    write_png(folder / "colour.png", colour);
    write_exr(folder / "normal.exr", {{"n", {"R", "G", "B"}, ExrPart::Type::kFloat, normal}}, {});
    scan.materials[0].diffuse = {folder / "colour.png", nullptr};
    scan.materials[0].normal = {folder / "normal.exr", nullptr};
  }
};

TEST(SourceBake, AMeshOntoItselfGivesItsOwnMaps) {
  const PicturedSheet sheet(64);
  BakeOptions options;
  const Model own = bake_model(sheet.scan, sheet.regions, kTable, options);
  options.source.scan = &sheet.scan;
  BakeReport report;
  const Model again = bake_model(sheet.scan, sheet.regions, kTable, options, &report);
  EXPECT_EQ(report.sets[0].hit_texels, 64u * 64u);
  EXPECT_LT(report.sets[0].max_distance_cm, 1e-3);
  const auto expect_near = [](const Image& a, const Image& b, float tolerance) {
    ASSERT_EQ(a.values.size(), b.values.size());
    float worst = 0;
    for (size_t i = 0; i < a.values.size(); ++i)
      worst = std::max(worst, std::fabs(a.values[i] - b.values[i]));
    EXPECT_LE(worst, tolerance);
  };
  const TextureSet &a = own.sets[0], &b = again.sets[0];
  expect_near(a.albedo, b.albedo, 1e-3f);  // a half near 1, and 1e-5 of a pixel of rounding in the UV
  expect_near(a.normal, b.normal, 2e-3f);
  expect_near(a.displacement, b.displacement, 1e-4f);
  expect_near(a.roughness, b.roughness, 0);
  expect_near(a.valid, b.valid, 0);
}

TEST(SourceBake, SmallMapsAverageTheSourcesPicture) {
  // Noise of 512 pixels into 16 texels: a point sample would be off by the noise itself, 0.29.
  const PicturedSheet sheet(512);
  BakeOptions options;
  options.size_px = 16;
  const Model own = bake_model(sheet.scan, sheet.regions, kTable, options);
  options.source.scan = &sheet.scan;
  const Model again = bake_model(sheet.scan, sheet.regions, kTable, options);
  double squared = 0;
  for (size_t i = 0; i < own.sets[0].albedo.values.size(); ++i) {
    const double error = own.sets[0].albedo.values[i] - again.sets[0].albedo.values[i];
    squared += error * error;
  }
  EXPECT_LT(std::sqrt(squared / double(own.sets[0].albedo.values.size())), 0.01);
}

TEST(SourceBake, SameBytesForAnyNumberOfThreads) {
  const PicturedSheet sheet(128);
  BakeOptions options;
  options.name = "sheet";
  options.size_px = 100;
  options.source.scan = &sheet.scan;
  options.source.wants_object_normals = true;
  const TemporaryFolder out;
  for (size_t threads : {1, 2, 8}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    bake_to_folder(sheet.scan, canonical_mesh(sheet.scan, sheet.regions, 1), kTable, options,
                   out / std::to_string(threads));
  }
  int files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(out / "1")) {
    if (!entry.is_regular_file()) continue;
    ++files;
    const std::string relative = std::filesystem::relative(entry.path(), out / "1").string();
    for (const char* other : {"2", "8"})
      EXPECT_EQ(read_file(entry.path()), read_file(out / other / relative)) << relative;
  }
  EXPECT_GT(files, 17);
  EXPECT_TRUE(std::filesystem::exists(out / "1/maps/all/height.exr"));
  EXPECT_TRUE(std::filesystem::exists(out / "1/maps/all/normal_object.exr"));
}

TEST(SourceBake, ACageReachesAsFarAsItIsMoved) {
  const auto sheet = [](float z) { return height_field(4, 100, [z](float, float) { return z; }); };
  const Scan low = scan_of_model(sheet(0), "low.obj"), high = scan_of_model(sheet(8), "high.obj");
  BakeOptions options;
  options.source.scan = &high;
  options.source.reach_cm = 9;
  options.size_px = 8;
  EXPECT_NEAR(bake_model(low, one_class(low), kTable, options).sets[0].displacement.values[0], 8, 1e-4f);
  const Scan near_cage = scan_of_model(sheet(5), "cage.obj"), far_cage = scan_of_model(sheet(10), "cage.obj");
  options.source.cage = &far_cage;
  EXPECT_NEAR(bake_model(low, one_class(low), kTable, options).sets[0].displacement.values[0], 8, 1e-4f);
  options.source.cage = &high;  // another mesh of the same faces is a cage
  options.source.cage = &near_cage;
  options.source.reach_cm = 1;
  options.source.max_missed_share = 0;
  expect_message(input_error_of([&] { bake_model(low, one_class(low), kTable, options); }),
                 {"high.obj", "lies 8", "cm away"});
  Scan other = near_cage;
  other.corners.pop_back();
  other.face_begin.back() -= 1;
  options.source.cage = &other;
  options.source.reach_cm = 9;
  expect_message(input_error_of([&] { bake_model(low, one_class(low), kTable, options); }),
                 {"cage.obj", "has other faces than low.obj"});
}

TEST(SourceBake, RefusesInWords) {
  const auto sheet = [](float z) { return height_field(4, 100, [z](float, float) { return z; }); };
  const Scan low = scan_of_model(sheet(0), "low.obj");
  BakeOptions options;
  options.size_px = 16;
  const auto refusal = [&](const Model& source) {
    const Scan high = scan_of_model(source, "high.obj");
    options.source.scan = &high;
    return input_error_of([&] { bake_model(low, one_class(low), kTable, options); });
  };
  expect_message(refusal(turned_over(sheet(0))),
                 {"texture set 'all'", "100.00 % find only back faces", "turn the faces"});
  expect_message(refusal(sheet(50)), {"lies 50", "cm away from the scan"});
  Model metres = sheet(0);
  for (Vec3f& p : metres.positions_cm) p *= 0.01f;
  expect_message(refusal(metres), {"times as large as the scan", "--source-unit"});
  const Scan twice = scan_of_model(joined(sheet(0), sheet(0.01f)), "twice.obj"),
             good = scan_of_model(sheet(0), "h.obj");
  options.source.scan = &good;
  expect_message(input_error_of([&] { bake_model(twice, one_class(twice), kTable, options); }),
                 {"h.obj", "100.00 % of the texels show more than one face", "--max-overlap"});
  Model half = sheet(0);
  half.triangles.resize(half.triangles.size() / 2);
  options.source.reach_cm = 1;
  expect_message(refusal(half), {"of its texels find no surface of the source within 1 cm", "--reach"});
  options.source.max_missed_share = 1;
  const Scan high = scan_of_model(half, "high.obj");
  options.source.scan = &high;
  BakeReport report;
  const Model model = bake_model(low, one_class(low), kTable, options, &report);
  EXPECT_GT(report.sets[0].missed_texels, 100u);
  EXPECT_EQ(*model.sets[0].valid.pixel(3, 0), 0.5f);
  const TemporaryFolder out;
  bake_to_folder(low, canonical_mesh(low, one_class(low), 1), kTable, options, out / "m");
  const Image debug = read_image(out / "m/maps/all/debug.png");
  EXPECT_EQ(debug.pixel(3, 0)[0], 1.0f);  // missed: red
  EXPECT_EQ(debug.pixel(3, 0)[1], 0.0f);
  EXPECT_GT(debug.pixel(3, 15)[1], 0.2f);  // hit: green
  EXPECT_EQ(debug.pixel(3, 15)[0], 0.0f);
}

}  // namespace
}  // namespace ohb
