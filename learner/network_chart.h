// Networks side by side: accuracy against time.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "learner/evaluate.h"

namespace ohb::learner {

struct NetworkChartOptions {
  std::vector<std::filesystem::path> sets;  // as weights_of_set takes each
  std::filesystem::path data;
  std::vector<std::string> people;     // as EvaluateOptions
  int size_px = 0;                     // 0: the largest that one of the networks was trained at
  torch::Device device = torch::kCPU;  // of the networks
  bool quiet = false;
};

struct NetworkMarks {
  std::string name;                   // of the set
  std::vector<std::string> networks;  // in words
  double million_parameters = 0;
  double billion_multiplies = 0;   // of a picture at the size that each network sees
  double seconds = 0;              // a picture, by the networks
  Marks mean;                      // over people, of the estimate
  std::vector<std::string> known;  // of the people: those whom a network was trained on (only if named)
  Interval maps_mean_dB;           // over people (bootstrap)
  bool is_on_front = false;        // nothing is both faster and better, by the mean of the maps
};

struct NetworkChart {
  std::vector<NetworkMarks> sets;  // as given
  size_t people = 0, pictures = 0;
  int size_px = 0;
  /// The fastest within kAsGood_dB of the best, by the mean of the maps.
  const NetworkMarks& to_take() const;
};
constexpr double kAsGood_dB = 0.2;

/// The runs or weights files of a set: a file; a run's folder; or a folder of weights files and runs, sorted
/// by name. Throws InputError if there is none of these.
std::vector<std::filesystem::path> weights_of_set(const std::filesystem::path& set);

/// All sets on the same pictures, of people whom none of them was trained on (unless they are named). Throws
/// InputError as evaluate does, and for a set whose networks do not estimate all maps.
NetworkChart chart_networks(const NetworkChartOptions& options);

std::string network_chart_table(const NetworkChart& chart);
std::string network_chart_csv(const NetworkChart& chart);
nlohmann::json network_chart_json(const NetworkChart& chart);
/// chart.svg and chart.png: mean of the maps, albedo and normals against seconds a picture. Throws InputError
/// if gnuplot is missing.
void draw_network_chart(const NetworkChart& chart, const std::filesystem::path& folder);

}  // namespace ohb::learner
