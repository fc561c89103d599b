// Mip levels that --mips ships: read from the file with OpenImageIO, the two sides of every seam compared
// with a sampler that shares no code with the bake's.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "bake/bake.h"
#include "tests/bake/test_scans.h"
#include "tests/support/paths.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace bake;
using namespace surface;
namespace {

struct Pixels {
  int width = 0, height = 0;
  std::vector<float> rgb;
};

/// All levels of the file, finest first.
std::vector<Pixels> levels_of(const std::filesystem::path& file) {
  std::vector<Pixels> levels;
  const auto input = OIIO::ImageInput::open(file.string());
  if (!input) return levels;
  for (int l = 0; input->seek_subimage(0, l); ++l) {
    const OIIO::ImageSpec spec = input->spec();
    Pixels level{spec.width, spec.height, std::vector<float>(size_t(3) * spec.width * spec.height)};
    EXPECT_GT(spec.tile_width, 0);
    EXPECT_EQ(spec.nchannels, 3);
    EXPECT_TRUE(input->read_image(0, l, 0, 3, OIIO::TypeDesc::FLOAT, level.rgb.data()));
    levels.push_back(level);
  }
  return levels;
}

/// Means of 2 x 2 pixels, for even sizes.
Pixels box(const Pixels& fine) {
  Pixels half{fine.width / 2, fine.height / 2, {}};
  for (int y = 0; y < half.height; ++y)
    for (int x = 0; x < half.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const auto at = [&](int i, int j) {
          return fine.rgb[3 * (size_t(2 * y + j) * fine.width + 2 * x + i) + c];
        };
        half.rgb.push_back((at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) / 4);
      }
  return half;
}

/// sRGB-encoded bilinear lookup, 0 to 255.
double lookup(const Pixels& level, double u, double v, int channel) {
  const double x = u * level.width - 0.5, y = (1 - v) * level.height - 0.5;
  double value = 0;
  for (int dy = 0; dy < 2; ++dy)
    for (int dx = 0; dx < 2; ++dx) {
      const long i = std::lround(std::floor(x)) + dx, j = std::lround(std::floor(y)) + dy;
      const double weight = (1 - std::fabs(x - double(i))) * (1 - std::fabs(y - double(j)));
      const size_t column = size_t((i % level.width + level.width) % level.width);
      const size_t row = size_t((j % level.height + level.height) % level.height);
      value += weight * level.rgb[3 * (row * level.width + column) + channel];
    }
  return 255 * (value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055);
}

using UvPair = std::pair<Vec2f, Vec2f>;  // of the two ends of an edge

/// The edges of the mesh with two places in UV.
std::vector<std::pair<UvPair, UvPair>> seams_of(const Model& model) {
  std::map<std::pair<uint32_t, uint32_t>, UvPair> first;
  std::vector<std::pair<UvPair, UvPair>> seams;
  for (const ModelTriangle& triangle : model.triangles)
    for (int c = 0; c < 3; ++c) {
      int a = c, b = (c + 1) % 3;
      if (triangle.position[a] > triangle.position[b]) std::swap(a, b);
      const UvPair uvs{model.uvs[triangle.uv[a]], model.uvs[triangle.uv[b]]};
      const auto [found, is_new] = first.emplace(std::pair(triangle.position[a], triangle.position[b]), uvs);
      const UvPair& other = found->second;
      if (!is_new && (other.first.x != uvs.first.x || other.first.y != uvs.first.y ||
                      other.second.x != uvs.second.x || other.second.y != uvs.second.y))
        seams.emplace_back(other, uvs);
    }
  return seams;
}

/// The mean over 53 points of each seam of the largest difference of a channel, in 1/255 of sRGB.
double difference_of(const Pixels& level, const std::vector<std::pair<UvPair, UvPair>>& seams) {
  constexpr int kPoints = 53;
  double mean = 0;
  for (const auto& [a, b] : seams)
    for (int i = 0; i < kPoints; ++i) {
      const double t = (i + 0.5) / kPoints;
      double worst = 0;
      for (int c = 0; c < 3; ++c) {
        const auto at = [&](const UvPair& side) {
          return lookup(level, (1 - t) * side.first.x + t * side.second.x,
                        (1 - t) * side.first.y + t * side.second.y, c);
        };
        worst = std::max(worst, std::fabs(at(a) - at(b)));
      }
      mean += worst / kPoints / double(seams.size());
    }
  return mean;
}

TEST(ShippedMips, SidesOfSeamsAgreeAtEachLevel) {
  const Scan scan = read_scan(source_path("assets/example_human/example_human.glb"));
  const MaterialTable table{};
  const TemporaryFolder folder;
  BakeOptions options;
  options.size_px = 1024;
  options.wants_mips = true;
  const CanonicalMesh mesh = canonical_mesh(scan, one_class(scan), 100);
  const BakeReport report = bake_to_folder(scan, mesh, table, options, folder.path());
  const auto seams = seams_of(mesh.model);
  ASSERT_GT(seams.size(), 500u);
  const std::vector<Pixels> levels = levels_of(folder / ("maps/" + report.sets.at(0).folder + "/albedo.exr"));
  ASSERT_EQ(levels.size(), 11u);
  EXPECT_EQ(levels.back().width, 1);
  // Level 2 of this small map is what level 4 is of one of 4096 x 4096. Measured: 1.11, 0.91, 1.49, 2.31; at
  // level 4 nearly all texels lie at a seam.
  constexpr double kMostMean[5] = {1.2, 1.0, 1.6, 2.5, 3.5};
  // Edges of charts smaller than two texels, of triangles without area or under others are not mended.
  const size_t not_mended = report.sets.at(0).seam_edges_left_out;
  EXPECT_EQ(seams.size(), report.sets.at(0).seam_edges + not_mended);
  EXPECT_LT(not_mended, seams.size() / 20);
  Pixels plain = levels[0];
  for (int l = 0; l < 5; ++l) {
    if (l > 0) plain = box(plain);
    const double difference = difference_of(levels[l], seams);
    EXPECT_LE(difference, kMostMean[l]) << l;
    if (l > 1) {
      EXPECT_GT(difference_of(plain, seams), 2 * difference) << l;
    }
    // Mending changes the borders of charts, not their colours.
    double changed = 0;
    for (size_t i = 0; i < plain.rgb.size(); ++i) changed += std::fabs(plain.rgb[i] - levels[l].rgb[i]);
    EXPECT_LT(changed / double(plain.rgb.size()), 0.02) << l;
  }
}

}  // namespace
}  // namespace ohb
