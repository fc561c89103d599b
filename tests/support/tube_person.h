// A person made of one tube, 170 cm high: the least that has a face, hair, clothes and shoes in their places
// and colours. Any fineness, for tests of invariance.
#pragma once

#include <cmath>

#include "dataset/model/colour.h"
#include "dataset/model/regions.h"
#include "dataset/model/scan.h"
#include "tests/support/scan_files.h"
#include "tests/support/test_files.h"

namespace ohb {

struct TubePerson {
  TemporaryFolder folder;
  Scan scan;  // in cm
  std::vector<uint8_t> truth;
};

constexpr double kTubeHeight_cm = 170;

/// The class at an angle (0: +Z, the front) and a height.
inline MaterialClass tube_class(double angle, double y_cm) {
  if (y_cm < 7) return kLeather;
  if (y_cm < 145) return kFabric;
  if (y_cm < 160) return std::abs(angle) < 1.2 || y_cm < 150 ? kSkin : kHair;
  return kHair;
}

inline Vec3f tube_srgb(MaterialClass material_class, double y_cm) {
  switch (material_class) {
    case kSkin:
      return {0.85f, 0.64f, 0.53f};
    case kHair:
      return {0.16f, 0.11f, 0.08f};
    case kLeather:
      return {0.30f, 0.18f, 0.10f};
    default:
      return y_cm < 85 ? Vec3f{0.25f, 0.30f, 0.42f} : Vec3f{0.70f, 0.72f, 0.75f};
  }
}

/// `around` x `high` quads, rounded at the top; the picture has a grain of +-0.02. Bald: hair is painted as
/// skin.
inline void make_tube_person(int around, int high, TubePerson& person, bool is_bald = false) {
  constexpr int kWidth_px = 256, kHeight_px = 1024;
  constexpr double kPi = 3.14159265358979;
  Image picture(kWidth_px, kHeight_px, 3);
  for (int y = 0; y < kHeight_px; ++y)
    for (int x = 0; x < kWidth_px; ++x) {
      const double height = kTubeHeight_cm * (1 - (y + 0.5) / kHeight_px);
      const double angle = 2 * kPi * ((x + 0.5) / kWidth_px - 0.5);
      const MaterialClass here = tube_class(angle, height);
      const Vec3f colour = tube_srgb(is_bald && here == kHair ? kSkin : here, height);
      const float grain = 0.02f * static_cast<float>((x * 7919 + y * 104729) % 101 - 50) / 50;
      for (int c = 0; c < 3; ++c) picture.pixel(x, y)[c] = colour[c] + grain;
    }
  write_png(person.folder / "tube.png", picture);
  Scan& scan = person.scan;
  scan.file = person.folder / "tube.obj";
  scan.materials.resize(1);
  scan.materials[0].name = "atlas";
  scan.materials[0].diffuse.file = person.folder / "tube.png";
  scan.groups = {"tube"};
  for (int j = 0; j <= high; ++j)
    for (int i = 0; i <= around; ++i) {
      const double share = static_cast<double>(j) / high,
                   angle = 2 * kPi * (static_cast<double>(i % around) / around - 0.5);
      const double radius = 12 * std::min(1.0, std::sqrt(std::max(0.0, (1 - share) * kTubeHeight_cm / 6)));
      scan.positions.push_back({static_cast<float>(radius * std::sin(angle)),
                                static_cast<float>(kTubeHeight_cm * share),
                                static_cast<float>(radius * std::cos(angle))});
      scan.uvs.push_back({static_cast<float>(i) / static_cast<float>(around), static_cast<float>(share)});
    }
  scan.face_begin = {0};
  for (int j = 0; j < high; ++j)
    for (int i = 0; i < around; ++i) {
      for (const auto& [di, dj] : {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1)}) {
        const auto index = static_cast<uint32_t>((j + dj) * (around + 1) + i + di);
        scan.corners.push_back({index, index});
      }
      scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
      scan.face_material.push_back(0);
      scan.face_group.push_back(0);
      person.truth.push_back(
          tube_class(2 * kPi * ((i + 0.5) / around - 0.5), kTubeHeight_cm * (j + 0.5) / high));
    }
}

/// The same as tube.obj with tube.mtl in its folder, all of one material.
inline std::filesystem::path write_tube_obj(const TubePerson& person, const std::string& material) {
  std::string obj = "mtllib tube.mtl\nusemtl " + material + "\n";
  for (Vec3f p : person.scan.positions)
    obj += "v " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
  for (Vec2f uv : person.scan.uvs) obj += "vt " + std::to_string(uv.x) + " " + std::to_string(uv.y) + "\n";
  for (size_t c = 0; c < person.scan.corners.size(); ++c) {
    const std::string index = std::to_string(person.scan.corners[c].position + 1);
    obj += (c % 4 == 0 ? "\nf " : " ") + index + "/" + index;
  }
  write_bytes(person.folder / "tube.mtl", "newmtl " + material + "\nmap_Kd tube.png\n");
  return write_bytes(person.folder / "tube.obj", obj + "\n");
}

}  // namespace ohb
