#include "dataset/environments/landscape.h"

#include <cmath>

#include "dataset/model/noise.h"

namespace ohb::environments {
namespace {

struct Ground {
  const char* name;
  Vec3f albedo;
  float roughness;
};
constexpr Ground kGrounds[] = {
    {"grass", {0.06f, 0.10f, 0.03f}, 0.5f},     {"asphalt", {0.12f, 0.12f, 0.12f}, 0.2f},
    {"sand", {0.42f, 0.34f, 0.23f}, 0.2f},      {"paving", {0.28f, 0.27f, 0.25f}, 0.25f},
    {"dry earth", {0.23f, 0.16f, 0.10f}, 0.4f}, {"snow", {0.80f, 0.82f, 0.85f}, 0.1f},
    {"brick", {0.26f, 0.13f, 0.09f}, 0.35f},    {"stubble", {0.34f, 0.28f, 0.14f}, 0.45f},
};
constexpr Vec3f kSkylineAlbedo[] = {{0.08f, 0.09f, 0.06f}, {0.04f, 0.065f, 0.03f}, {0.24f, 0.21f, 0.18f}};

float skyline_at(const Landscape& land, float cosine, float sine) {
  const Vec3f round{cosine, sine, 0.5f};
  switch (land.skyline) {
    case Landscape::Skyline::kHills:
      return land.skyline_height * fractal_noise(round * 1.7f, 5, land.pattern);
    case Landscape::Skyline::kTrees:
      return land.skyline_height * (0.3f + 0.4f * fractal_noise(round * 4, 3, land.pattern) +
                                    0.3f * fractal_noise(round * 40, 3, land.pattern + 1));
    case Landscape::Skyline::kHouses: {
      const float turn = 0.5f + std::atan2(sine, cosine) / (2 * kPi);
      const int house = static_cast<int>(turn * 26);
      const float gap = cell_number(house, 1, 0, land.pattern);
      return land.skyline_height *
             (gap < 0.15f ? 0.1f : 0.35f + 0.65f * cell_number(house, 0, 0, land.pattern));
    }
  }
  return 0;
}

/// A house's front has a colour of its own and rows of windows.
Vec3f house_albedo(const Landscape& land, float cosine, float sine, float tangent) {
  const float turn = 26 * (0.5f + std::atan2(sine, cosine) / (2 * kPi));
  const int house = static_cast<int>(turn);
  Vec3f colour = land.skyline_albedo;
  for (int c = 0; c < 3; ++c) colour[c] *= 0.6f + 0.8f * cell_number(house, 2 + (c == 2), 7, land.pattern);
  const float column = (turn - static_cast<float>(house)) * 5, row = tangent / land.skyline_height * 7;
  const bool is_window = std::fabs(column - std::floor(column) - 0.5f) < 0.22f &&
                         std::fabs(row - std::floor(row) - 0.5f) < 0.25f;
  return is_window ? colour * 0.3f : colour;
}

}  // namespace

std::string Landscape::words() const {
  const char* const names[] = {"hills", "trees", "houses"};
  return ground + " and " + names[static_cast<int>(skyline)];
}

Landscape draw_landscape(Random& random) {
  Landscape land;
  const auto pick = [&](int count) {
    return std::min(static_cast<int>(random.next() * static_cast<float>(count)), count - 1);
  };
  // Snow is rarer than the rest.
  int which = pick(8);
  if (which == 5 && random.next() < 0.5f) which = 3;
  const Ground& ground = kGrounds[which];
  land.ground = ground.name;
  land.albedo = ground.albedo * (0.75f + 0.5f * random.next());
  for (int c = 0; c < 3; ++c) land.albedo[c] = std::min(land.albedo[c], 0.85f);
  land.roughness = ground.roughness;
  const int skyline = pick(3);
  land.skyline = static_cast<Landscape::Skyline>(skyline);
  land.skyline_albedo = kSkylineAlbedo[skyline] * (0.7f + 0.6f * random.next());
  const float tallest[] = {0.16f, 0.25f, 0.45f};
  land.skyline_height = tallest[skyline] * (0.3f + 0.7f * random.next());
  land.pattern = random.next_bits();
  return land;
}

Vec3f irradiance_from_above(const RadianceOf& sky) {
  constexpr int kRows = 64, kColumns = 256;
  Vec3f sum;
  // Even in cos^2: each direction has the same share of the projected hemisphere.
  for (int row = 0; row < kRows; ++row) {
    const float cosine = std::sqrt((static_cast<float>(row) + 0.5f) / kRows),
                sine = std::sqrt(1 - cosine * cosine);
    for (int column = 0; column < kColumns; ++column) {
      const float phi = 2 * kPi * (static_cast<float>(column) + 0.5f) / kColumns;
      sum += sky({sine * std::cos(phi), cosine, sine * std::sin(phi)});
    }
  }
  return sum * (kPi / (kRows * kColumns));
}

bool sees_landscape(const Landscape& land, Vec3f direction, Vec3f on_ground, Vec3f haze, Vec3f& radiance) {
  const float flat = std::sqrt(std::max(1e-12f, direction.x * direction.x + direction.z * direction.z));
  const float tangent = direction.y / flat, cosine = direction.x / flat, sine = direction.z / flat;
  if (direction.y > 0) {
    if (tangent > skyline_at(land, cosine, sine)) return false;
    Vec3f albedo = land.skyline_albedo;
    if (land.skyline == Landscape::Skyline::kHouses)
      albedo = house_albedo(land, cosine, sine, tangent);
    else
      albedo *= 0.6f + 0.8f * fractal_noise(Vec3f{cosine, 2 * tangent, sine} * 25, 4, land.pattern + 2);
    const float far = land.skyline == Landscape::Skyline::kHills ? 0.45f : 0.15f;
    radiance = albedo * on_ground * (0.5f * (1 - far) / kPi) + haze * far;
    return true;
  }
  constexpr float kEye_m = 1.6f;
  const float distance_m = std::min(kEye_m / std::max(-tangent, 1e-4f), 400.0f);
  const Vec3f place{cosine * distance_m, 0, sine * distance_m};
  // Detail finer than a texel far away would be noise: it fades into its mean.
  const float near = 1 / (1 + distance_m / 6);
  const float pattern = fractal_noise(place * 1.3f, 4, land.pattern + 3) - 0.5f,
              broad = fractal_noise(place * 0.15f, 3, land.pattern + 4) - 0.5f;
  const float light = 1 + 2 * land.roughness * (near * pattern + 0.6f * broad / (1 + distance_m / 60));
  const float fade = 0.5f * smooth(20, 400, distance_m);
  radiance = land.albedo * on_ground * (light / kPi * (1 - fade)) + haze * fade;
  return true;
}

float fractal_noise(Vec3f p, int octaves, uint64_t which) {
  float sum = 0, weight = 0.5f, total = 0;
  for (int k = 0; k < octaves; ++k) {
    sum += weight * value_noise(p, which + 16 * static_cast<uint64_t>(k));
    total += weight;
    p = p * 2.03f, weight *= 0.5f;
  }
  return sum / total;
}

}  // namespace ohb::environments
