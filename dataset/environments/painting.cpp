#include "dataset/environments/painting.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "dataset/environments/sphere_map.h"
#include "dataset/model/parallel.h"

namespace ohb::environments {
namespace {

constexpr double kPiDouble = 3.14159265358979323846;

/// Directions that divide each texel evenly: even in azimuth and in the cosine, so even in solid angle. For
/// all texels of a map, each with `samples` squared.
class Directions {
 public:
  Directions(int width_px, int samples) : samples_(samples) {
    const int columns = width_px * samples, height_px = width_px / 2;
    for (int i = 0; i < columns; ++i) {
      const double phi = ((i + 0.5) / columns - 0.5) * 2 * kPiDouble;
      columns_.push_back({static_cast<float>(std::cos(phi)), static_cast<float>(std::sin(phi))});
    }
    for (int y = 0; y < height_px; ++y)
      for (int j = 0; j < samples; ++j) {
        const double top = std::cos(kPiDouble * y / height_px),
                     bottom = std::cos(kPiDouble * (y + 1) / height_px);
        const double cosine = top + (bottom - top) * (j + 0.5) / samples;
        rows_.push_back({static_cast<float>(cosine), static_cast<float>(std::sqrt(1 - cosine * cosine))});
      }
  }
  int samples() const { return samples_; }
  /// Sample (i, j) of texel (x, y).
  Vec3f at(int x, int y, int i, int j) const {
    const Vec2f column = columns_[static_cast<size_t>(x * samples_ + i)],
                row = rows_[static_cast<size_t>(y * samples_ + j)];
    return {row.y * column.x, row.x, row.y * column.y};
  }

 private:
  int samples_;
  std::vector<Vec2f> columns_, rows_;  // cosine and sine of the azimuth; cosine and sine of the polar angle
};

/// Of the samples of a texel: the sum of their channels.
struct Spread {
  float lowest = 0, highest = 0;
};
/// A texel whose samples differ by more than this ratio is sampled more finely.
constexpr float kEven = 1.15f;

Vec3f texel_mean(const Directions& directions, int x, int y, const RadianceOf& radiance, Spread& spread) {
  Vec3f sum;
  const int samples = directions.samples();
  for (int j = 0; j < samples; ++j)
    for (int i = 0; i < samples; ++i) {
      const Vec3f light = radiance(directions.at(x, y, i, j));
      const float level = light.x + light.y + light.z;
      const bool is_first = i == 0 && j == 0;
      spread.lowest = is_first ? level : std::min(spread.lowest, level);
      spread.highest = is_first ? level : std::max(spread.highest, level);
      sum += light;
    }
  return sum / static_cast<float>(samples * samples);
}

/// Share of a texel that the disc covers, of kDiscSamples squared samples.
constexpr int kDiscSamples = 16;
double covered_share(const Image& map, int x, int y, Vec3f towards, float radius_rad) {
  double azimuths[kDiscSamples][2];
  for (int i = 0; i < kDiscSamples; ++i) {
    const double phi = ((x + (i + 0.5) / kDiscSamples) / map.width_px - 0.5) * 2 * kPiDouble;
    azimuths[i][0] = std::cos(phi), azimuths[i][1] = std::sin(phi);
  }
  const double top = std::cos(kPiDouble * y / map.height_px),
               bottom = std::cos(kPiDouble * (y + 1) / map.height_px);
  // By the sine of half the angle: a cosine so near 1 has no digits left.
  const float chord = 2 * std::sin(radius_rad / 2);
  int inside = 0;
  for (int j = 0; j < kDiscSamples; ++j) {
    const double cosine = top + (bottom - top) * (j + 0.5) / kDiscSamples;
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    for (const auto& azimuth : azimuths) {
      const Vec3f way{static_cast<float>(sine * azimuth[0]), static_cast<float>(cosine),
                      static_cast<float>(sine * azimuth[1])};
      inside += length(way - towards) < chord;
    }
  }
  return static_cast<double>(inside) / (kDiscSamples * kDiscSamples);
}

}  // namespace

Image painted(int width_px, int samples, const RadianceOf& radiance) {
  Image map(width_px, width_px / 2, 3);
  const Directions coarse(width_px, samples), fine(width_px, 2 * samples);
  parallel_for_each(0, map.height_px, [&](int y) {
    for (int x = 0; x < width_px; ++x) {
      Spread spread;
      Vec3f mean = texel_mean(coarse, x, y, radiance, spread);
      if (spread.highest > kEven * spread.lowest) mean = texel_mean(fine, x, y, radiance, spread);
      for (int c = 0; c < 3; ++c) map.pixel(x, y)[c] = std::max(0.0f, mean[c]);
    }
  });
  return map;
}

void add_disc(Image& map, Vec3f towards, float radius_rad, Vec3f irradiance) {
  struct Touched {
    int x, y;
    double share;
  };
  std::vector<Touched> touched;
  double covered = 0;
  const double texel_rad = kPiDouble / map.height_px;
  for (int y = 0; y < map.height_px; ++y) {
    const double theta = (y + 0.5) * texel_rad, of_disc = std::acos(std::clamp(towards.y, -1.0f, 1.0f));
    if (std::fabs(theta - of_disc) > static_cast<double>(radius_rad) + texel_rad) continue;
    for (int x = 0; x < map.width_px; ++x) {
      const double share = covered_share(map, x, y, towards, radius_rad);
      if (share == 0) continue;
      touched.push_back({x, y, share});
      covered += share * texel_solid_angle(y, map.width_px, map.height_px);
    }
  }
  if (touched.empty()) {  // so small that it lies between the samples
    const int y = std::min(static_cast<int>(std::acos(std::clamp(towards.y, -1.0f, 1.0f)) / texel_rad),
                           map.height_px - 1);
    const double turns = 0.5 + std::atan2(towards.z, towards.x) / (2 * kPiDouble);
    touched.push_back({std::min(static_cast<int>(turns * map.width_px), map.width_px - 1), y, 1});
    covered = texel_solid_angle(y, map.width_px, map.height_px);
  }
  const double energy_share = 2 / (1 + std::cos(static_cast<double>(radius_rad)));
  for (const Touched& texel : touched)
    for (int c = 0; c < 3; ++c)
      map.pixel(texel.x, texel.y)[c] +=
          static_cast<float>(static_cast<double>(irradiance[c]) * energy_share * texel.share / covered);
}

}  // namespace ohb::environments
