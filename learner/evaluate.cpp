#include "learner/evaluate.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "dataset/model/error.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/progress.h"
#include "learner/data.h"
#include "learner/estimator.h"
#include "learner/unseen.h"

namespace ohb::learner {
namespace fs = std::filesystem;
namespace {

using torch::Tensor;

constexpr size_t kViewsForConstant = 64;
enum Row { kFinetuned, kPriors, kConstant, kInputAsAlbedo, kEightBit, kRowCount };
constexpr std::array<const char*, kRowCount> kRowNames = {"finetuned", "priors", "constant",
                                                          "input as albedo", "8-bit truth"};

Scores no_scores() {
  Scores scores;
  scores.fill({std::nan(""), std::nan("")});
  return scores;
}

/// Mean of the encoded maps over the foreground of (some of) the views: (1, channels, 1, 1).
Tensor mean_maps(const std::vector<fs::path>& views, int size_px) {
  Tensor sum = torch::zeros({1, output_channels(Task::kFinetune), 1, 1}, torch::kDouble);
  double weight = 0;
  const size_t stride = std::max<size_t>(1, views.size() / kViewsForConstant);
  for (size_t i = 0; i < views.size(); i += stride) {
    throw_if_interrupted();
    const Example e = read_example(views[i], 0, size_px);
    sum += (encoded_maps(Task::kFinetune, e.truth) * e.mask).sum({2, 3}, true);
    weight += e.mask.sum().item<double>();
  }
  return (sum / weight).to(torch::kFloat);
}

/// The training people's views, or `otherwise` where there is none in the data.
std::vector<fs::path> views_of_constant(const Dataset& dataset, const TrainedOn& trained,
                                        const std::vector<fs::path>& otherwise) {
  std::vector<std::string> names;
  for (const auto& [name, by] : trained) names.push_back(name);
  const std::vector<fs::path> training = views_of(dataset, names);
  return training.empty() ? otherwise : training;
}

MaterialMaps constant_maps(const Tensor& mean, const MaterialMaps& truth) {
  return maps_of(Task::kFinetune,
                 mean.expand({1, mean.size(1), truth.normal.size(2), truth.normal.size(3)}).contiguous(), {});
}

/// The foreground's colour as it is, without the mask in it.
Tensor input_colour(const Example& e) {
  return ((e.input.slice(1, 0, 3) + 1) / 2 / e.mask.clamp_min(1e-3)).clamp(0, 1);
}

struct Sum {
  MeanOf<Scores> psnr;
  MeanOf<Measures> measures;

  void add(const Scores& scores, const Measures& measured) {
    psnr.add(scores);
    measures.add(measured);
  }
  Marks mean() const { return {psnr.mean(), measures.mean()}; }
};

/// One value of each person of a row.
template <typename ValueOf>
std::vector<double> values_of(const EvaluationRow& row, ValueOf value_of) {
  std::vector<double> values;
  for (const auto& [person, marks] : row.people) values.push_back(value_of(marks));
  return values;
}

/// Means, deviations and intervals over the people of a row.
void summarise(EvaluationRow& row) {
  Sum over_people;
  for (const auto& [person, marks] : row.people) over_people.add(marks.psnr, marks.measures);
  row.mean = over_people.mean();
  for (size_t c = 0; c < kColumns.size(); ++c) {
    const std::vector<double> values = values_of(row, [&](const Marks& m) { return m.psnr[c].masked; });
    double squares = 0;
    for (const double value : values) squares += std::pow(value - row.mean.psnr[c].masked, 2);
    row.deviation_dB[c] = std::sqrt(squares / static_cast<double>(values.size()));
    row.interval_dB[c] = bootstrap_of_mean(values);
  }
  for (size_t m = 0; m < kMeasureCount; ++m)
    row.interval[m] =
        bootstrap_of_mean(values_of(row, [&](const Marks& marks) { return marks.measures[m]; }));
}

/// A row's marks by group of people.
std::vector<PartOfPictures> by_group(const EvaluationRow& row) {
  std::vector<std::string> people;
  for (const auto& [person, marks] : row.people) people.push_back(person);
  std::vector<PartOfPictures> parts;
  for (const auto& [name, members] : groups_of(people)) {
    Sum sum;
    for (const std::string& person : members)
      sum.add(row.people.at(person).psnr, row.people.at(person).measures);
    parts.push_back({name, members.size(), sum.mean()});
  }
  return parts;
}

std::string words_of(const nlohmann::json& header) {
  return fmt::format("{} (width {:g}, {} steps)", header.value("task", "?"), header.value("width", 0.0),
                     header.value("step", int64_t{0}));
}

class Evaluation {
 public:
  /// `relit` may be null.
  Evaluation(const Estimator& estimator, Tensor constant, RelitScores* relit)
      : estimator_(estimator), constant_(std::move(constant)), relit_(relit) {}

  /// One picture under a light of that name; relit too where a camera is given.
  void add(const Example& e, const std::string& light, const std::optional<Camera>& camera) {
    const auto start = std::chrono::steady_clock::now();
    const MaterialMaps priors = estimator_.from_priors(e.input);
    const MaterialMaps refined = estimator_.has_finetune() ? estimator_.estimate(e.input) : priors;
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    ++pictures_;
    const bool relights = relit_ && camera;
    if (relights) relit_->begin(e, *camera);
    const auto put = [&](Row row, const MaterialMaps& maps) {
      Scores scores = scores_of(maps, e.truth, e.mask);
      const Measures measures = measures_of(maps, e.truth, e.mask);
      // There is no picture of maps that are not all there.
      if (row == kPriors && !estimator_.is_whole()) scores.back() = {std::nan(""), std::nan("")};
      sums_[e.person][row].add(scores, measures);
      if (row == (estimator_.has_finetune() ? kFinetuned : kPriors)) by_light_[light].add(scores, measures);
      if (relights) relit_->add(name_of(row), maps);
    };
    if (estimator_.has_finetune()) put(kFinetuned, refined);
    put(kPriors, priors);
    put(kConstant, constant_maps(constant_, e.truth));
    put(kEightBit, eight_bit(e.truth));
    Scores albedo = no_scores();
    albedo[1] = psnr(input_colour(e), srgb_of(e.truth.diffuse), e.mask);
    sums_[e.person][kInputAsAlbedo].add(albedo,
                                        albedo_measures(linear_of(input_colour(e)), e.truth.diffuse, e.mask));
  }

  EvaluationReport report() const {
    EvaluationReport report;
    report.pictures = pictures_;
    report.seconds_a_picture = seconds_ / static_cast<double>(std::max<size_t>(1, pictures_));
    for (int row = 0; row < kRowCount; ++row) {
      EvaluationRow r;
      r.name = name_of(static_cast<Row>(row));
      for (const auto& [person, rows] : sums_)
        if (const auto found = rows.find(static_cast<Row>(row)); found != rows.end())
          r.people[person] = found->second.mean();
      if (r.people.empty()) continue;
      summarise(r);
      report.rows.push_back(r);
    }
    for (const auto& [light, sum] : by_light_) report.lights.push_back({light, sum.psnr.count(), sum.mean()});
    return report;
  }

 private:
  std::string name_of(Row row) const {
    return row == kPriors && estimator_.is_joint() ? "joint" : kRowNames[row];
  }

  const Estimator& estimator_;
  Tensor constant_;
  RelitScores* relit_;
  std::map<std::string, std::map<Row, Sum>> sums_;
  std::map<std::string, Sum> by_light_;  // of the estimate
  double seconds_ = 0;
  size_t pictures_ = 0;
};

int size_to_judge(const EvaluateOptions& options, const Estimator& estimator) {
  const int size_px = options.size_px > 0 ? options.size_px : estimator.header().at("size_px").get<int>();
  if (size_px % kResolutionStep != 0)
    throw InputError("", "--size " + std::to_string(size_px), "is no multiple of 16", "give another");
  return size_px;
}

}  // namespace

EvaluationReport evaluate(const EvaluateOptions& options) {
  const Estimator estimator(options.weights, PriorsNeeded::kAny, options.device);
  const Dataset dataset = read_dataset(options.data);
  const TrainedOn trained = trained_on(estimator.headers());
  const std::vector<std::string> people = people_to_judge(options.people, dataset, estimator.headers());
  const int size_px = size_to_judge(options, estimator);
  const std::vector<fs::path> views = views_of(dataset, people);
  std::optional<RelitScores> relit;
  if (options.relit.views_a_person > 0 && !estimator.is_whole())
    spdlog::info("not relit: that needs all the maps, and so geometry, albedo and rss");
  else if (options.relit.views_a_person > 0)
    relit.emplace(options.relit);
  const auto to_relight = relit_views(dataset, people, options.relit.views_a_person);
  Evaluation evaluation(estimator, mean_maps(views_of_constant(dataset, trained, views), size_px),
                        relit ? &*relit : nullptr);
  Progress progress("evaluating", views.size(), options.quiet);
  for (const fs::path& view : views) {
    throw_if_interrupted();
    const Sample sample = read_sample(view);
    const auto chosen = to_relight.find(view);
    for (size_t light = 0; light < sample.lights.size(); ++light) {
      const bool relights = chosen != to_relight.end() && chosen->second % sample.lights.size() == light;
      evaluation.add(example_of(sample, view, light, size_px), sample.lights[light].name,
                     relights ? std::optional(camera_of(sample, view)) : std::nullopt);
    }
    progress.add();
  }
  EvaluationReport report = evaluation.report();
  report.people = people;
  for (const std::string& name : people)
    if (const auto by = trained.find(name); by != trained.end()) report.trained_on.insert(*by);
  report.size_px = size_px;
  report.groups = by_group(report.rows.front());
  for (const nlohmann::json& header : estimator.headers()) report.networks.push_back(words_of(header));
  if (relit) report.relit = relit->report();
  return report;
}

}  // namespace ohb::learner
