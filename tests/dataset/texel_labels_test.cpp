// Borders at texels, on an arm whose true border is known as a curve and cuts through large faces.
#include "dataset/labelling/texel_labels.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <random>

#include "dataset/commands/label.h"
#include "dataset/labelling/texel_surface.h"

#include "tests/support/scan_files.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace commands;
using namespace labelling;
using namespace surface;
namespace {

constexpr double kTurn = 2 * 3.14159265358979;
constexpr double kRadius_cm = 5, kHeight_cm = 30, kWave_cm = 2;

/// `contrast` 0: both classes are of one colour. `noise`: standard deviation of the picture's values in
/// [0,1]. `gradient`: how much brighter the arm is at its upper end.
struct Look {
  float contrast, noise, gradient;
};

/// A sleeve that ends in waves on an arm: a closed tube of quads, with a UV seam, skin below and fabric
/// above.
struct Arm {
  TemporaryFolder folder;
  Scan scan;
  std::vector<uint8_t> face_class;  // by the middle of each face
  int around, up;

  static double border_at(double turn) { return 0.5 * kHeight_cm + kWave_cm * std::sin(3 * kTurn * turn); }
  static uint8_t truth(double turn, double y) { return y < border_at(turn) ? kSkin : kFabric; }

  Arm(int faces_around, int picture_px, const Look& look) : around(faces_around), up(faces_around) {
    for (int j = 0; j <= up; ++j)
      for (int i = 0; i < around; ++i) {
        const double angle = kTurn * i / around;
        scan.positions.push_back({static_cast<float>(kRadius_cm * std::sin(angle)),
                                  static_cast<float>(kHeight_cm * j / up),
                                  static_cast<float>(kRadius_cm * std::cos(angle))});
      }
    for (int j = 0; j <= up; ++j)
      for (int i = 0; i <= around; ++i)
        scan.uvs.push_back({static_cast<float>(i) / static_cast<float>(around),
                            static_cast<float>(j) / static_cast<float>(up)});
    scan.face_begin = {0};
    for (int j = 0; j < up; ++j)
      for (int i = 0; i < around; ++i) {
        for (const auto& [right, above] :
             {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1)})
          scan.corners.push_back({static_cast<uint32_t>((j + above) * around + (i + right) % around),
                                  static_cast<uint32_t>((j + above) * (around + 1) + i + right)});
        scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
        face_class.push_back(truth((i + 0.5) / around, kHeight_cm * (j + 0.5) / up));
      }
    scan.face_material.assign(scan.face_begin.size() - 1, 0);
    scan.face_group.assign(scan.face_begin.size() - 1, 0);
    scan.groups = {"arm"};
    scan.materials.resize(1);
    scan.materials[0].diffuse.file = folder / "arm.png";
    const Vec3f skin{0.8f, 0.6f, 0.5f}, cloth{0.3f, 0.35f, 0.6f};
    Image picture(picture_px, picture_px, 3);
    std::mt19937 random(5);
    std::normal_distribution<float> normal(0, 1);
    for (int y = 0; y < picture_px; ++y)
      for (int x = 0; x < picture_px; ++x) {
        const bool is_cloth =
            truth((x + 0.5) / picture_px, kHeight_cm * (1 - (y + 0.5) / picture_px)) == kFabric;
        const Vec3f colour = skin + (is_cloth ? look.contrast : 0) * (cloth - skin) +
                             Vec3f{1, 1, 1} * (look.gradient * (0.5f - static_cast<float>(y) / picture_px));
        for (int c = 0; c < 3; ++c)
          picture.pixel(x, y)[c] = std::clamp(colour[c] + look.noise * normal(random), 0.0f, 1.0f);
      }
    write_png(scan.materials[0].diffuse.file, picture);
  }

  /// Mean distance of the border from the true one in mm: the wrong area over its length.
  template <typename ClassAt>
  double error_mm(const ClassAt& class_at) const {
    constexpr int kSamples = 400;
    double wrong_cm2 = 0, length_cm = 0;
    for (int i = 0; i < kSamples; ++i) {
      const double turn = (i + 0.5) / kSamples;
      for (int j = 0; j < kSamples; ++j) {
        const double y = kHeight_cm * (j + 0.5) / kSamples;
        wrong_cm2 +=
            (class_at(turn, y) != truth(turn, y)) * kTurn * kRadius_cm * kHeight_cm / (kSamples * kSamples);
      }
      length_cm += std::hypot(kTurn * kRadius_cm / kSamples,
                              border_at(turn + 0.5 / kSamples) - border_at(turn - 0.5 / kSamples));
    }
    return 10 * wrong_cm2 / length_cm;
  }
  uint32_t face_at(double turn, double y) const {
    return static_cast<uint32_t>(static_cast<int>(y / kHeight_cm * up) * around +
                                 static_cast<int>(turn * around));
  }
  double face_error_mm() const {
    return error_mm([&](double turn, double y) { return face_class[face_at(turn, y)]; });
  }
  uint8_t texel_class(const TexelLabels& labels, double turn, double y) const {
    const double step = turn * around;
    const auto first = static_cast<size_t>(step);
    const Vec3f a = scan.positions[first], b = scan.positions[(first + 1) % static_cast<size_t>(around)];
    Vec3f at = a + static_cast<float>(step - static_cast<double>(first)) * (b - a);  // on the flat face
    at.y = static_cast<float>(y);
    return labels.class_at(0, face_at(turn, y), turn, 1 - y / kHeight_cm, at);
  }
  double texel_error_mm(const TexelLabels& labels) const {
    return error_mm([&](double turn, double y) { return texel_class(labels, turn, y); });
  }
};

TEST(TexelLabels, FollowThePictureThroughLargeFaces) {
  for (const int around : {8, 16, 64})
    for (const Look look :
         {Look{1, 0, 0}, {1, 0.15f, 0}, {0.3f, 0.02f, 0.4f}, {0.3f, 0.1f, 0}, {0.1f, 0.02f, 0}}) {
      const Arm arm(around, 512, look);
      const TexelLabels labels({arm.scan, 1}, arm.face_class, {}, false);
      // Texels are 0.6 mm; faces are wrong by 9.8, 3.7 and 1.1 mm.
      EXPECT_GT(arm.face_error_mm(), 1);
      EXPECT_LT(arm.texel_error_mm(labels), look.noise > 0.05f ? 0.5 : 0.3)
          << around << " " << look.contrast << " " << look.noise;
      EXPECT_NEAR(labels.summary().changed_cm2, arm.face_error_mm() / 10 * 40, 3) << around;
    }
}

TEST(TexelLabels, StayWithTheFacesWhereNothingShowsTheBorder) {
  for (const int around : {16, 64})
    for (const Look look : {Look{0, 0, 0}, {0, 0.1f, 0}, {0.1f, 0.1f, 0}, {0, 0.02f, 0.4f}}) {
      const Arm arm(around, 512, look);
      const TexelLabels labels({arm.scan, 1}, arm.face_class, {}, false);
      EXPECT_LE(arm.texel_error_mm(labels), arm.face_error_mm())
          << around << " " << look.contrast << " " << look.noise << " " << look.gradient;
    }
}

TEST(TexelLabels, FacesThatAreGivenKeepTheirClassAndSmallOnesAreLeft) {
  const Arm arm(16, 256, {1, 0, 0});
  std::vector<bool> given(arm.face_class.size(), false);
  const uint32_t face = arm.face_at(0.28, Arm::border_at(0.28));  // the border runs through it
  given[face] = true;
  const TexelLabels labels({arm.scan, 1}, arm.face_class, given, false);
  size_t others = 0;
  arm.error_mm([&](double turn, double y) {
    const uint8_t at = arm.texel_class(labels, turn, y);
    if (arm.face_at(turn, y) == face) others += at != arm.face_class[face];
    return at;
  });
  EXPECT_EQ(others, 0u);
  EXPECT_GT(labels.summary().changed_cm2, 10);
  EXPECT_TRUE(TexelLabels({arm.scan, 1}, arm.face_class, {}, true).summary().is_refined);
  // The same in millimetres: edges of 1 mm and less.
  const TexelLabels small({arm.scan, 0.04}, arm.face_class, {}, true);
  EXPECT_FALSE(small.summary().is_refined);
  EXPECT_NE(small.summary().reason, "");
  EXPECT_EQ(arm.error_mm([&](double turn, double y) { return arm.texel_class(small, turn, y); }),
            arm.face_error_mm());
}

TEST(TexelLabels, TheNumberOfThreadsDoesNotMatter) {
  const Arm arm(16, 256, {0.3f, 0.1f, 0});
  std::vector<std::vector<uint8_t>> results;
  for (const size_t threads : {1, 3}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const TexelLabels labels({arm.scan, 1}, arm.face_class, {}, false);
    results.emplace_back();
    arm.error_mm([&](double turn, double y) {
      results.back().push_back(arm.texel_class(labels, turn, y));
      return results.back().back();
    });
  }
  EXPECT_EQ(results[0], results[1]);
}

TEST(TexelLabels, TexelsAreLinkedAcrossASeam) {
  constexpr int kSize_px = 256;
  const Arm arm(16, kSize_px, {1, 0, 0});
  const ScanSurface scan_surface(arm.scan, 1);
  const TexelSurface surface(scan_surface, std::vector<bool>(arm.face_class.size(), true));
  double across_cm = 0, rest_cm = 0;
  std::vector<int> seen(kSize_px, 0);
  for (const TexelLink& link : surface.links()) {
    const int x = static_cast<int>(link.texel[0].index % kSize_px),
              other = static_cast<int>(link.texel[1].index % kSize_px);
    if (std::abs(x - other) == kSize_px - 1) {
      across_cm += length(link.b - link.a);
      ++seen[link.texel[0].index / kSize_px];
      EXPECT_LE(std::abs(static_cast<int>(link.texel[0].index / kSize_px) -
                         static_cast<int>(link.texel[1].index / kSize_px)),
                1);
    } else {
      EXPECT_LE(std::abs(x - other), 1);
      if (x != other) rest_cm += length(link.b - link.a);
    }
  }
  EXPECT_NEAR(across_cm, kHeight_cm, 1e-3);
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 0), 0);
  EXPECT_NEAR(rest_cm, (kSize_px - 1) * kHeight_cm, 1);  // the borders of the other columns
}

TEST(TexelLabels, ReachTheWeightsThatBakeReads) {
  Arm arm(16, 512, {1, 0.02f, 0});
  std::string obj = "mtllib arm.mtl\nusemtl arm\n", faces;
  for (const Vec3f p : arm.scan.positions) obj += fmt::format("v {} {} {}\n", p.x, p.y, p.z);
  for (const Vec2f p : arm.scan.uvs) obj += fmt::format("vt {} {}\n", p.x, p.y);
  for (size_t f = 0; f < arm.face_class.size(); ++f) {
    obj += "f";
    for (size_t c = 4 * f; c < 4 * f + 4; ++c)
      obj += fmt::format(" {}/{}", arm.scan.corners[c].position + 1, arm.scan.corners[c].uv + 1);
    obj += "\n";
    faces += fmt::format("{}\n", arm.face_class[f]);
  }
  LabelJob job;
  job.scan = write_bytes(arm.folder / "arm.obj", obj);
  write_bytes(arm.folder / "arm.mtl", "newmtl arm\nmap_Kd arm.png\n");
  job.faces = write_bytes(arm.folder / "faces.txt", faces);
  job.unit = "cm";
  const auto wrong_mm = [&](RefineBorders refine) {
    job.refine = refine;
    job.output = arm.folder / (refine == RefineBorders::kOn ? "on" : "auto");
    const LabelReport report = label_scan(job);
    EXPECT_EQ(report.texel_borders.has_value(), refine == RefineBorders::kOn);
    const auto parts = read_exr(job.output / "maps/arm/weights.exr");
    const ExrPart& weights = find_part(parts, "weights", "weights.exr");
    const auto channel = [&](const char* name) {  // files sort channels by name
      return std::find(weights.channels.begin(), weights.channels.end(), name) - weights.channels.begin();
    };
    const auto skin = channel("skin"), fabric = channel("fabric");
    return arm.error_mm([&](double turn, double y) {
      const float* const p =
          weights.image.pixel(static_cast<int>(turn * 512), static_cast<int>((1 - y / kHeight_cm) * 512));
      EXPECT_NEAR(p[0] + p[1] + p[2] + p[3], 1, 2e-3f);
      return p[skin] > p[fabric] ? kSkin : kFabric;
    });
  };
  EXPECT_LT(wrong_mm(RefineBorders::kOn), 0.4);
  EXPECT_NEAR(wrong_mm(RefineBorders::kAuto), arm.face_error_mm(),
              0.2);  // finished classes are taken as they are
}

}  // namespace
}  // namespace ohb
