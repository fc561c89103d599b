// Where estimates break: the same people in harder and harder pictures.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "learner/measures.h"
#include "learner/metrics.h"

namespace ohb::learner {

struct StressOptions {
  std::vector<std::filesystem::path> weights;  // files or runs: as Estimator takes them
  std::filesystem::path data;
  std::vector<std::string> people;     // as EvaluateOptions
  int size_px = 0;                     // 0: as trained
  torch::Device device = torch::kCPU;  // of the networks
  int views_a_person = 1;              // evenly around the turn
  int spp = 32;                        // of the pictures, which our path tracer makes
  uint64_t seed = 1;                   // of the noise
  bool quiet = false;
};

/// Means over the pictures of a level.
struct StressLevel {
  double level = 0;
  size_t pictures = 0;
  Scores psnr;
  Measures measures;
  double input_as_albedo_dB = 0;  // masked
  double change = 0;    // of the albedo against that of the harmless picture: mean difference over mean; NaN
                        // where the pixels show something else
  double baked_in = 0;  // correlation of the albedo's log error with the picture's log shading; 0 is clean
  double seconds = 0;   // of processors, by the networks, a picture
};

struct StressSeries {
  std::string name, parameter;
  double harmless = 0;
  std::vector<StressLevel> levels;
  /// Levels whose albedo is more than kBroken_dB below the harmless picture's.
  std::vector<double> broken() const;
};
constexpr double kBroken_dB = 3;

struct StressReport {
  std::vector<StressSeries> series;
  size_t people = 0;
  int size_px = 0;
};

/// A relief of each chosen view's true maps is rendered under a sky and a sun (relit_radiance; no
/// subsurface, no back of the person), and the pictures of stress_kinds are made of both.
/// Throws InputError as evaluate does.
StressReport run_stress(const StressOptions& options);

std::string stress_table(const StressReport& report);
std::string stress_csv(const StressReport& report);
nlohmann::json stress_json(const StressReport& report);
/// chart.svg and chart.png: a row a kind: albedo, normals, shading baked in; the last row against time.
/// Throws InputError if gnuplot is missing.
void draw_stress(const StressReport& report, const std::filesystem::path& folder);

}  // namespace ohb::learner
