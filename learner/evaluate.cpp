#include "learner/evaluate.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>

#include "dataset/model/error.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/progress.h"
#include "learner/data.h"
#include "learner/estimator.h"

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

using TrainedOn = std::map<std::string, std::vector<std::string>>;

/// Which of the networks were trained on whom.
TrainedOn trained_on(const std::vector<nlohmann::json>& headers) {
  TrainedOn trained;
  for (const nlohmann::json& header : headers)
    for (const auto& name : header.value("trained_on", std::vector<std::string>{}))
      trained[name].push_back(header.at("task").get<std::string>());
  return trained;
}

/// Those of `people` whom none of the networks was trained on; the others are named if they are few.
std::vector<std::string> unseen(const std::vector<std::string>& people, const TrainedOn& trained) {
  std::vector<std::string> found;
  for (const std::string& name : people)
    if (const auto by = trained.find(name); by == trained.end())
      found.push_back(name);
    else
      spdlog::warn("{} is left out: {} was trained on that person", name, fmt::join(by->second, ", "));
  return found;
}

std::vector<std::string> people_of(const EvaluateOptions& options, const Dataset& dataset,
                                   const Estimator& estimator, const TrainedOn& trained) {
  std::set<std::string> there, held_out;
  for (const Person& person : dataset.people) there.insert(person.name);
  for (const std::string& name : options.people)
    if (there.count(name) == 0)
      throw InputError(options.data.string(), "--person " + name, "nobody of that name is in the dataset",
                       "names are the samples' ohb:human");
  if (!options.people.empty()) return options.people;
  for (const nlohmann::json& header : estimator.headers())
    for (const auto& name : header.value("held_out", std::vector<std::string>{}))
      if (there.count(name)) held_out.insert(name);
  std::vector<std::string> found = unseen({held_out.begin(), held_out.end()}, trained);
  if (!found.empty()) return found;
  for (const std::string& name : there)
    if (trained.count(name) == 0) found.push_back(name);
  if (found.empty())
    throw InputError(options.data.string(), "", "the networks were trained on everybody there",
                     "give other people's samples, or name some with --person: the table will mark them");
  spdlog::warn("nobody whom training held out is in {}: everybody there is evaluated whom it was not done on",
               options.data.string());
  return found;
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

MaterialMaps constant_maps(const Tensor& mean, const MaterialMaps& truth) {
  return maps_of(Task::kFinetune,
                 mean.expand({1, mean.size(1), truth.normal.size(2), truth.normal.size(3)}).contiguous(), {});
}

/// The foreground's colour as it is, without the mask in it.
Tensor input_colour(const Example& e) {
  return ((e.input.slice(1, 0, 3) + 1) / 2 / e.mask.clamp_min(1e-3)).clamp(0, 1);
}

class Evaluation {
 public:
  /// `relit` may be null.
  Evaluation(const Estimator& estimator, Tensor constant, RelitScores* relit)
      : estimator_(estimator), constant_(std::move(constant)), relit_(relit) {}

  /// One picture; relit too where a camera is given.
  void add(const Example& e, const std::optional<Camera>& camera) {
    const auto start = std::chrono::steady_clock::now();
    const MaterialMaps priors = estimator_.from_priors(e.input);
    const MaterialMaps refined = estimator_.has_finetune() ? estimator_.estimate(e.input) : priors;
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    ++pictures_;
    const bool relights = relit_ && camera;
    if (relights) relit_->begin(e, *camera);
    const auto put = [&](Row row, const MaterialMaps& maps) {
      Scores scores = scores_of(maps, e.truth, e.mask);
      // The picture of maps that are not all there: the shader takes NaN for dark.
      if (row == kPriors && !estimator_.is_whole()) scores.back() = {std::nan(""), std::nan("")};
      sums_[e.person][row].add(scores);
      if (relights) relit_->add(kRowNames[row], maps);
    };
    if (estimator_.has_finetune()) put(kFinetuned, refined);
    put(kPriors, priors);
    put(kConstant, constant_maps(constant_, e.truth));
    put(kEightBit, eight_bit(e.truth));
    Scores albedo = no_scores();
    albedo[1] = psnr(input_colour(e), srgb_of(e.truth.diffuse), e.mask);
    sums_[e.person][kInputAsAlbedo].add(albedo);
  }

  EvaluationReport report() const {
    EvaluationReport report;
    report.pictures = pictures_;
    report.seconds_a_picture = seconds_ / static_cast<double>(std::max<size_t>(1, pictures_));
    for (int row = 0; row < kRowCount; ++row) {
      EvaluationRow r{kRowNames[row], {}, {}, {}};
      MeanOf<Scores> over_people;
      for (const auto& [person, rows] : sums_) {
        const auto found = rows.find(static_cast<Row>(row));
        if (found == rows.end()) continue;
        r.people[person] = found->second.mean();
        over_people.add(r.people[person]);
      }
      if (over_people.count() == 0) continue;
      r.mean = over_people.mean();
      for (size_t c = 0; c < kColumns.size(); ++c) {
        double squares = 0;
        for (const auto& [person, scores] : r.people)
          squares += std::pow(scores[c].masked - r.mean[c].masked, 2);
        r.deviation_dB[c] = std::sqrt(squares / static_cast<double>(r.people.size()));
      }
      report.rows.push_back(r);
    }
    return report;
  }

 private:
  const Estimator& estimator_;
  Tensor constant_;
  RelitScores* relit_;
  std::map<std::string, std::map<Row, MeanOf<Scores>>> sums_;
  double seconds_ = 0;
  size_t pictures_ = 0;
};

double material_mean(const Scores& scores, double Psnr::*value) {
  double sum = 0;
  for (size_t i = 0; i < kMaps.size(); ++i) sum += scores[i].*value;
  return sum / static_cast<double>(kMaps.size());
}

std::string table_of(const EvaluationReport& report, double Psnr::*value, const std::string& title) {
  std::string text = title + "\n\n| row             |";
  for (const char* column : kColumns) text += fmt::format(" {:>6} |", column);
  text += " maps mean |\n|-----------------|";
  for (size_t i = 0; i < kColumns.size(); ++i) text += "-------:|";
  text += "----------:|\n";
  for (const EvaluationRow& row : report.rows) {
    text += fmt::format("| {:<15} |", row.name);
    for (const Psnr& score : row.mean) text += table_cell(score.*value);
    text += "   " + table_cell(material_mean(row.mean, value)) + "\n";
  }
  return text + "\n";
}

}  // namespace

EvaluationReport evaluate(const EvaluateOptions& options) {
  const Estimator estimator(options.weights, PriorsNeeded::kAny);
  const Dataset dataset = read_dataset(options.data);
  const TrainedOn trained = trained_on(estimator.headers());
  const std::vector<std::string> people = people_of(options, dataset, estimator, trained);
  const int size_px = options.size_px > 0 ? options.size_px : estimator.header().at("size_px").get<int>();
  if (size_px % kResolutionStep != 0)
    throw InputError("", "--size " + std::to_string(size_px), "is no multiple of 16", "give another");
  const std::vector<fs::path> views = views_of(dataset, people);
  std::vector<std::string> names;
  for (const auto& [name, by] : trained) names.push_back(name);
  const std::vector<fs::path> training = views_of(dataset, names);
  std::optional<RelitScores> relit;
  if (options.relit.views_a_person > 0 && !estimator.is_whole())
    spdlog::info("not relit: that needs all the maps, and so geometry, albedo and rss");
  else if (options.relit.views_a_person > 0)
    relit.emplace(options.relit);
  const auto to_relight = relit_views(dataset, people, options.relit.views_a_person);
  Evaluation evaluation(estimator, mean_maps(training.empty() ? views : training, size_px),
                        relit ? &*relit : nullptr);
  Progress progress("evaluating", views.size(), options.quiet);
  for (const fs::path& view : views) {
    throw_if_interrupted();
    const Sample sample = read_sample(view);
    const auto chosen = to_relight.find(view);
    for (size_t light = 0; light < sample.lights.size(); ++light) {
      const bool relights = chosen != to_relight.end() && chosen->second % sample.lights.size() == light;
      evaluation.add(example_of(sample, view, light, size_px),
                     relights ? std::optional(camera_of(sample, view)) : std::nullopt);
    }
    progress.add();
  }
  EvaluationReport report = evaluation.report();
  report.people = people;
  for (const std::string& name : people)
    if (const auto by = trained.find(name); by != trained.end()) report.trained_on.insert(*by);
  report.size_px = size_px;
  if (relit) report.relit = relit->report();
  return report;
}

std::string table_of(const EvaluationReport& report) {
  std::string marks;
  for (const auto& [name, by] : report.trained_on)
    marks += fmt::format("TRAINED ON, not held out: {} (by {})\n\n", name, fmt::join(by, ", "));
  return marks +
         table_of(report, &Psnr::masked,
                  "PSNR over the foreground, dB: mean over pictures, then over people") +
         table_of(report, &Psnr::full, "PSNR over the whole frame, dB") +
         (report.relit ? table_of(*report.relit) : "");
}

nlohmann::json json_of(const EvaluationReport& report) {
  const auto scores_json = [&](const Scores& scores) {
    nlohmann::json json;
    for (size_t i = 0; i < scores.size(); ++i)
      json[kColumns[i]] = {{"masked", json_number(scores[i].masked)}, {"full", json_number(scores[i].full)}};
    json["maps_mean"] = {{"masked", json_number(material_mean(scores, &Psnr::masked))},
                         {"full", json_number(material_mean(scores, &Psnr::full))}};
    return json;
  };
  nlohmann::json json = {{"people", report.people},
                         {"trained_on", report.trained_on},
                         {"pictures", report.pictures},
                         {"size_px", report.size_px},
                         {"seconds_a_picture", report.seconds_a_picture}};
  for (const EvaluationRow& row : report.rows) {
    nlohmann::json r = {{"name", row.name}, {"mean", scores_json(row.mean)}};
    for (size_t i = 0; i < kColumns.size(); ++i)
      r["deviation_dB"][kColumns[i]] = json_number(row.deviation_dB[i]);
    for (const auto& [person, scores] : row.people) r["people"][person] = scores_json(scores);
    json["rows"].push_back(r);
  }
  if (report.relit) json["relighting"] = json_of(*report.relit);
  return json;
}

}  // namespace ohb::learner
