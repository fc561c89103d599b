#include "learner/network_chart.h"

#include <algorithm>

#include "dataset/model/error.h"
#include "learner/checkpoint.h"
#include "learner/counts.h"
#include "learner/estimator.h"
#include "learner/unseen.h"

namespace ohb::learner {
namespace fs = std::filesystem;
namespace {

bool is_run(const fs::path& folder) {
  return newest_checkpoint(folder) || fs::is_regular_file(folder / kWeightsName);
}

/// Parameters and multiplies of all networks of a set, each at the size that it sees.
void add_costs(const Estimator& estimator, NetworkMarks& marks) {
  const std::vector<Network> networks = estimator.networks();
  const int size_px = estimator.header().at("size_px");
  for (const Network& network : networks) {
    marks.million_parameters += 1e-6 * static_cast<double>(parameter_count(network.module()));
    marks.billion_multiplies += 1e-9 * static_cast<double>(multiplies_of(network, size_px));
  }
}

double mean_of_maps(const Marks& marks) {
  return maps_mean(marks.psnr, &Psnr::masked);
}

void add_marks(const EvaluationReport& report, NetworkMarks& marks) {
  const EvaluationRow& row = report.rows.front();
  marks.networks = report.networks;
  marks.seconds = report.seconds_a_picture;
  marks.mean = row.mean;
  for (const auto& [name, by] : report.trained_on) marks.known.push_back(name);
  std::vector<double> of_people;
  for (const auto& [name, person] : row.people) of_people.push_back(mean_of_maps(person));
  marks.maps_mean_dB = bootstrap_of_mean(of_people);
}

void mark_front(std::vector<NetworkMarks>& sets) {
  for (NetworkMarks& one : sets)
    one.is_on_front = std::none_of(sets.begin(), sets.end(), [&](const NetworkMarks& other) {
      return other.seconds < one.seconds && mean_of_maps(other.mean) >= mean_of_maps(one.mean);
    });
}

}  // namespace

std::vector<fs::path> weights_of_set(const fs::path& set) {
  if (!fs::is_directory(set) || is_run(set)) return {set};
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(set))
    if (entry.is_directory() ? is_run(entry.path()) : entry.path().extension() == ".safetensors")
      found.push_back(entry.path());
  if (found.empty())
    throw InputError(set.string(), "", "holds neither weights (.safetensors) nor runs",
                     "give another folder");
  std::sort(found.begin(), found.end());
  return found;
}

const NetworkMarks& NetworkChart::to_take() const {
  double best_dB = mean_of_maps(sets.front().mean);
  for (const NetworkMarks& one : sets) best_dB = std::max(best_dB, mean_of_maps(one.mean));
  const NetworkMarks* fastest = nullptr;
  for (const NetworkMarks& one : sets)
    if (mean_of_maps(one.mean) >= best_dB - kAsGood_dB && (!fastest || one.seconds < fastest->seconds))
      fastest = &one;
  return *fastest;
}

NetworkChart chart_networks(const NetworkChartOptions& options) {
  // Everything is read before the first picture, so that a bad set costs nobody an hour.
  NetworkChart chart;
  std::vector<nlohmann::json> headers;
  int largest_px = 0;
  for (const fs::path& set : options.sets) {
    const Estimator estimator(weights_of_set(set));
    NetworkMarks marks;
    marks.name = set.string();
    add_costs(estimator, marks);
    chart.sets.push_back(marks);
    headers.insert(headers.end(), estimator.headers().begin(), estimator.headers().end());
    largest_px = std::max(largest_px, estimator.header().at("size_px").get<int>());
  }
  EvaluateOptions evaluation;
  evaluation.data = options.data;
  evaluation.people = people_to_judge(options.people, read_dataset(options.data), headers);
  evaluation.size_px = options.size_px > 0 ? options.size_px : largest_px;
  evaluation.device = options.device;
  evaluation.relit.views_a_person = 0;
  evaluation.quiet = options.quiet;
  for (size_t i = 0; i < options.sets.size(); ++i) {
    evaluation.weights = weights_of_set(options.sets[i]);
    const EvaluationReport report = evaluate(evaluation);
    add_marks(report, chart.sets[i]);
    chart.people = report.people.size();
    chart.pictures = report.pictures;
    chart.size_px = report.size_px;
  }
  mark_front(chart.sets);
  return chart;
}

}  // namespace ohb::learner
