// A small maps folder (docs/maps_json.md) of the synthetic ball.
#pragma once

#include <nlohmann/json.hpp>

#include "dataset/model/atomic_file.h"
#include "dataset/model/camera.h"
#include "dataset/model/colour.h"
#include "test_samples.h"

namespace ohb {

inline void write_ball_maps(const std::filesystem::path& folder, int size_px) {
  constexpr int kBits = 16;
  constexpr double kRange_cm = 100, kHalfWidth = 0.5 * kSensorMm / kLensMm;
  Sample ball = ball_sample(size_px, "ball", 0);
  std::filesystem::create_directories(folder);
  for (float& v : ball.normal.values) v = 0.5f + 0.5f * v;
  for (float& v : ball.diffuse.values) v = linear_to_srgb(v);
  for (float& v : ball.displacement.values) v = 0.5f + 0.5f * v / static_cast<float>(kRange_cm);
  nlohmann::json maps;
  const auto add = [&](const std::string& name, const Image& image, const char* encoding) {
    write_png(folder / (name + ".png"), image, kBits);
    maps[name] = {{"file", name + ".png"}, {"encoding", encoding}};
  };
  add("mask", ball.mask, "coverage");
  add("normal", ball.normal, "offset");
  add("diffuse", ball.diffuse, "srgb");
  add("roughness", ball.roughness, "value");
  add("specular", ball.specular, "srgb_f0");
  add("sss", ball.sss, "value");
  add("displacement", ball.displacement, "offset");
  maps["displacement"]["r_cm"] = kRange_cm;
  const nlohmann::json json = {{"format", "humanmaterial.maps"},
                               {"version", 1},
                               {"unit", "cm"},
                               {"size_px", {size_px, size_px}},
                               {"camera",
                                {{"type", "perspective"},
                                 {"distance_cm", kRange_cm / kHalfWidth},
                                 {"half_width", kHalfWidth},
                                 {"center_y_cm", 100}}},
                               {"maps", maps}};
  write_file_atomically(folder / "maps.json", json.dump());
}

}  // namespace ohb
