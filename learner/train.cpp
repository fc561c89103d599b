#include "learner/train.h"

#include <ATen/record_function.h>
#include <fmt/format.h>
#include <malloc.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <limits>
#include <thread>

#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/error.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/json_text.h"
#include "learner/batch.h"
#include "learner/constant_loss.h"
#include "learner/hash.h"
#include "learner/ranks.h"
#include "learner/run_header.h"
#include "learner/run_log.h"

namespace ohb::learner {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;
using torch::Tensor;

enum Purpose : uint64_t {
  kLightPlace = 3,
  kMirror = 4,
  kRecolour = 5,
  kSnapshot = 6,
  kPart = 7,
  kMixture = 8
};
constexpr double kGrace_s = 6;  // for the step under way, so that it can be saved
constexpr int64_t kMaxSkippedInARow = 10;
constexpr double kUniform = 0.01;  // loss of one value everywhere, below which maps have no more than that
constexpr double kAverageDecay = 0.9995;  // two thousand steps

/// What one step came to.
struct Step {
  double total, map, render, gradient_norm;
  bool interrupted = false;  // one of the ranks
  bool finite() const { return std::isfinite(total) && std::isfinite(gradient_norm); }
};

/// Means of several steps.
struct Means {
  double total = 0, map = 0, render = 0, gradient_norm = 0;
  int64_t count = 0;

  void add(const Step& step) {
    total += step.total;
    map += step.map;
    render += step.render;
    gradient_norm += step.gradient_norm;
    ++count;
  }
  double mean(double sum) const { return count > 0 ? sum / static_cast<double>(count) : 0; }
  /// For the log; starts anew.
  json take() {
    const json line = {{"loss", mean(total)},
                       {"map", mean(map)},
                       {"render", mean(render)},
                       {"gradient_norm", mean(gradient_norm)}};
    *this = {};
    return line;
  }
};

void begin_with(const fs::path& file_or_run, Network& network) {
  const LoadedNetwork loaded = load_network(file_or_run);
  if (loaded.network.task != network.task || loaded.network.width != network.width ||
      loaded.network.residual != network.residual)
    throw InputError(
        loaded.file.string(), "",
        fmt::format("is another network: {}{}, width {:g}", loaded.network.residual ? "residual " : "",
                    name_of(loaded.network.task), loaded.network.width),
        "give one of the same model, --width and --residual");
  const torch::NoGradGuard no_gradients;
  const auto wanted = network.module().parameters(), start = loaded.network.module().parameters();
  for (size_t i = 0; i < wanted.size(); ++i) wanted[i].copy_(start[i]);
}

/// A run in progress.
class Trainer {
 public:
  explicit Trainer(const TrainOptions& options)
      : options_(options),
        ranks_(Ranks::from_environment()),
        dataset_(read_dataset(options.data)),
        split_(split_people(dataset_, options.held_out, options.seed)),
        views_(views_of(dataset_, split_.training)),
        steps_(options.steps > 0 ? options.steps : steps_of_epochs()),
        header_(run_header(options, dataset_, split_, steps_)),
        network_(make_seeded()),
        optimiser_(network_.module(), adamw_options()) {
    if (options_.batch % ranks_.count() != 0)
      throw InputError("", "--batch " + std::to_string(options_.batch),
                       "is no multiple of WORLD_SIZE, " + std::to_string(ranks_.count()),
                       "it is that of all ranks together: give another");
    if (!ranks_.is_first()) options_.quiet = true;
    if (options.guidance == Guidance::kPriors) {
      priors_ = std::make_unique<PriorSet>(options.priors);
      priors_->move_to(options.device);
    }
    first_step_ = ranks_.is_first() ? start_or_resume() : 0;
    agree_with_first();
  }

  TrainReport run();

 private:
  int64_t steps_of_epochs() const {
    return static_cast<int64_t>((views_.size() * static_cast<size_t>(options_.epochs) + options_.batch - 1) /
                                options_.batch);
  }
  Network make_seeded() const {
    torch::manual_seed(options_.seed);
    Network network = make_network(options_.task, options_.width, options_.residual);
    if (!options_.from.empty()) begin_with(options_.from, network);
    network.module().to(options_.device);  // drawn on the CPU: equal on any device
    return network;
  }
  /// The run's key for that purpose; 0, which leaves it out, unless it is asked for.
  uint64_t key_if(bool asked, Purpose purpose) const { return asked ? key_of({options_.seed, purpose}) : 0; }
  AdamW::Options adamw_options() const {
    AdamW::Options adamw;
    adamw.weight_decay = options_.weight_decay;
    adamw.average_decay = options_.average ? kAverageDecay : 0;
    return adamw;
  }
  int batch_of_rank() const { return options_.batch / ranks_.count(); }
  Loader::Settings loader_settings() const {
    Loader::Settings settings;
    settings.size_px = options_.size_px;
    settings.seed = options_.seed;
    settings.first_position = first_position_of(first_step_ + 1);
    settings.threads = options_.loader_threads;
    settings.ahead = 4 * batch_of_rank();
    settings.block = static_cast<uint64_t>(batch_of_rank());
    settings.stride = static_cast<uint64_t>(options_.batch);
    settings.keys = {key_if(options_.parts, kPart), key_if(options_.mix_lights, kMixture)};
    const Augmentation augmentation{key_if(options_.mirror, kMirror), key_if(options_.recolour, kRecolour),
                                    key_if(options_.snapshots, kSnapshot)};
    settings.vary = [augmentation](Example& e, uint64_t position) { vary(e, augmentation, position); };
    return settings;
  }
  uint64_t first_position_of(int64_t step) const {
    return static_cast<uint64_t>((step - 1) * options_.batch + ranks_.rank() * batch_of_rank());
  }
  int64_t start_or_resume();
  void agree_with_first();
  Losses losses_of_batch(const Batch& batch, int64_t number);
  void join(Step& result);
  Step step(const Batch& batch, int64_t number);
  void warn_if_nothing_is_learnt(double map_loss, double constant_loss);
  void note(const json& event) {
    if (log_) log_->add(event);
  }
  void note_skipped(const Batch& batch, int64_t number, int64_t in_a_row);
  void stop_if_interrupted(int64_t number, bool interrupted);
  void save(int64_t step);
  void finish(TrainReport& report);

  TrainOptions options_;
  Ranks ranks_;
  Dataset dataset_;
  Split split_;
  std::vector<fs::path> views_;
  int64_t steps_, first_step_ = 0;
  json header_;
  Network network_;
  AdamW optimiser_;
  std::unique_ptr<PriorSet> priors_;
  std::unique_ptr<RunLog> log_;  // of the first rank
};

int64_t Trainer::start_or_resume() {
  const auto newest = newest_checkpoint(options_.run);
  check_is_run(options_.run, newest.has_value());
  claim_folder(options_.run, "a training run");
  if (!newest) return 0;
  if (!options_.resume)
    throw InputError(options_.run.string(), "", "holds a run already",
                     "add --resume to go on with it, or choose another -o");
  sweep_leftovers(options_.run);
  check_same_run(read_checkpoint_header(*newest), header_, *newest);
  const int64_t done = load_checkpoint(*newest, optimiser_).at("step").get<int64_t>();
  if (done > steps_)
    throw InputError(newest->string(), "--steps " + std::to_string(steps_),
                     "is less than the " + std::to_string(done) + " steps that the run has made",
                     "give more, or use the run as it is");
  return done;
}

/// The others begin where rank 0 does, with its checkpoint, and only if they do the same.
void Trainer::agree_with_first() {
  if (ranks_.is_alone()) return;
  const json first = parse_json(
      ranks_.from_first(json_text(json{{"header", header_}, {"steps", steps_}, {"step", first_step_}})),
      "the first process");
  if (ranks_.is_first()) return;
  check_same_run(first["header"], header_, "rank 0");
  if (first["steps"] != steps_)
    throw InputError("rank 0", "steps", "are others than those of rank " + std::to_string(ranks_.rank()),
                     "give all ranks the same options");
  first_step_ = first["step"];
  if (first_step_ > 0) load_checkpoint(checkpoint_file(options_.run, first_step_), optimiser_);
}

/// Of this rank's part, each loss weighted so that the ranks' sum is the loss of the joint batch.
Losses Trainer::losses_of_batch(const Batch& batch, int64_t number) {
  Tensor guidance;
  if (options_.task == Task::kFinetune)
    guidance = priors_ ? priors_->guidance(batch.input) : encoded_maps(Task::kFinetune, batch.truth);
  const Tensor output = network_.forward(batch.input, guidance);
  const auto lights = training_lights(key_of({options_.seed, kLightPlace, static_cast<uint64_t>(number)}));
  shading::Options shading;
  shading.log_domain = !options_.linear_render;
  shading.min_roughness = std::min(shading.min_roughness, options_.control_roughness);
  const LossOptions loss = {options_.render_weight, shading, options_.balanced, options_.control_roughness};
  Losses losses = losses_of(options_.task, output, batch.truth, batch.mask, lights, loss);
  if (ranks_.is_alone()) return losses;
  // The maps' loss is a mean by coverage, the rendering loss one over pixels of the foreground.
  const double covered = batch.mask.sum().item<double>(), pixels = (batch.mask > 0.5).sum().item<double>();
  std::vector<double> all = {covered, pixels};
  ranks_.sum(all);
  losses.map = losses.map * (covered / all[0]);
  losses.render = losses.render * (pixels / all[1]);
  losses.total = losses.map + options_.render_weight * losses.render;
  return losses;
}

/// Losses and gradients of the joint batch.
void Trainer::join(Step& result) {
  std::vector<double> sums = {result.total, result.map, result.render, is_interrupted() ? 1.0 : 0.0};
  ranks_.sum(sums);
  result = {sums[0], sums[1], sums[2], 0, sums[3] > 0};
  if (!std::isfinite(result.total)) return;
  std::vector<Tensor> gradients;
  for (const AdamW::State& s : optimiser_.states())
    if (s.parameter.grad().defined()) gradients.push_back(s.parameter.grad());
  ranks_.sum(gradients);
}

Step Trainer::step(const Batch& batch, int64_t number) {
  optimiser_.clear_gradients();
  const Losses losses = losses_of_batch(batch, number);
  Step result{losses.total.item<double>(), losses.map.item<double>(), losses.render.item<double>(), 0};
  if (std::isfinite(result.total)) losses.total.backward();
  if (!ranks_.is_alone()) join(result);
  if (!std::isfinite(result.total)) return result;
  RECORD_USER_SCOPE("optimiser");
  result.gradient_norm = optimiser_.clip_gradients(options_.clip);
  if (result.finite()) optimiser_.update(learning_rate_at(options_, number, steps_), number);
  return result;
}

/// Too large a learning rate saturates a network: its loss stays finite, and stays.
void Trainer::warn_if_nothing_is_learnt(double map_loss, double constant_loss) {
  if (map_loss < constant_loss || constant_loss < kUniform) return;
  note({{"event", "nothing learnt"}, {"map", map_loss}, {"constant", constant_loss}});
  spdlog::warn(
      "nothing learnt: the maps' loss of the last steps is {:.4f}, that of one value everywhere {:.4f}; "
      "train longer, or with a lower --learning-rate",
      map_loss, constant_loss);
}

void Trainer::save(int64_t step) {
  if (!ranks_.is_first()) return;
  const Finishing whole;
  header_["step"] = step;
  header_["version"] = OHB_VERSION;
  save_checkpoint(options_.run, header_, optimiser_, options_.keep);
}

void Trainer::finish(TrainReport& report) {
  report.is_first_rank = ranks_.is_first();
  if (!ranks_.is_first()) return;
  header_["step"] = steps_;
  header_["version"] = OHB_VERSION;
  report.weights = options_.run / kWeightsName;
  optimiser_.take_averages();
  save_weights(report.weights, header_, network_);
}

void Trainer::note_skipped(const Batch& batch, int64_t number, int64_t in_a_row) {
  note({{"event", "skipped"}, {"step", number}, {"samples", batch.names}});
  spdlog::warn("step {} left out: loss or gradient is not finite for {}", number, batch.names[0]);
  if (in_a_row == kMaxSkippedInARow)
    throw InputError(batch.names[0], "step " + std::to_string(number),
                     "the loss or its gradient is not finite, for the tenth time in a row",
                     "look at the sample, or lower --learning-rate");
}

void Trainer::stop_if_interrupted(int64_t number, bool interrupted) {
  if (!interrupted) return;
  save(number);
  note({{"event", "stopped"}, {"step", number}});
  throw TryAgainError(options_.run.string(),
                      "stopped by a signal after step " + std::to_string(number) + ", which is saved",
                      "add --resume to go on");
}

TrainReport Trainer::run() {
  set_interrupt_grace_s(kGrace_s);
  TrainReport report;
  report.first_step = first_step_;
  report.steps = steps_;
  if (ranks_.is_first()) log_ = std::make_unique<RunLog>(options_.run / "log.jsonl", first_step_);
  note({{"event", first_step_ > 0 ? "resume" : "start"},
        {"step", first_step_},
        {"steps", steps_},
        {"threads", torch::get_num_threads()},
        {"ranks", ranks_.count()},
        {"device", options_.device.str()},
        {"options", header_}});
  Loader loader(views_, loader_settings());
  TrainProgress progress(first_step_, steps_, options_.quiet);
  const int64_t tenth = std::max<int64_t>(1, (steps_ - first_step_) / 10);
  Means logged, first, last;
  double constant = 0;
  int64_t in_a_row = 0;
  std::unique_ptr<StepProfile> profile;  // the first step, which makes threads and buffers, is left out
  for (int64_t number = first_step_ + 1; number <= steps_; ++number) {
    if (options_.profile && number == first_step_ + 2) profile = std::make_unique<StepProfile>();
    const Batch batch = moved_to(options_.device, next_batch(loader, batch_of_rank()));
    const Step result = step(batch, number);
    in_a_row = result.finite() ? 0 : in_a_row + 1;
    if (result.finite()) {
      logged.add(result);
      if (number - first_step_ <= tenth) first.add(result);
      if (steps_ - number < tenth) {
        last.add(result);
        constant += constant_map_loss(options_.task, batch.truth, batch.mask, options_.balanced);
      }
    } else {
      ++report.skipped;
      note_skipped(batch, number, in_a_row);
    }
    if (number % options_.log_every == 0 && logged.count > 0) {
      json line = logged.take();
      line["step"] = number;
      line["learning_rate"] = learning_rate_at(options_, number, steps_);
      line["seconds"] = progress.seconds();
      line["data_wait_s"] = loader.waited_s();
      note(line);
    }
    progress.show(number, result.total, loader.waited_s());
    if (number == steps_ || number % options_.checkpoint_every == 0) save(number);
    if (number < steps_)
      stop_if_interrupted(number, ranks_.is_alone() ? is_interrupted() : result.interrupted);
  }
  if (profile) report.profile = profile->lines();
  report.seconds = progress.seconds();
  report.data_wait_s = loader.waited_s();
  report.first_loss = first.mean(first.total);
  report.last_loss = last.mean(last.total);
  finish(report);
  if (last.count > 0 && ranks_.is_first())  // the constant's loss is of its part of the batches
    warn_if_nothing_is_learnt(last.mean(last.map), last.mean(constant));
  note({{"event", "done"}, {"step", steps_}, {"seconds", report.seconds}});
  return report;
}

}  // namespace

/// Each step asks for the same blocks again: what is freed stays with the process, since giving it back to
/// the system and getting it zeroed anew takes a tenth of a step.
void keep_freed_memory() {
  ::mallopt(M_MMAP_THRESHOLD, 32 << 20);  // the most that glibc takes
  ::mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
}

TrainReport train(const TrainOptions& options) {
  check_train_options(options);
  keep_freed_memory();
  const unsigned processors = std::max(1u, std::thread::hardware_concurrency());
  torch::set_num_threads(options.threads > 0 ? options.threads : static_cast<int>(processors));
  return Trainer(options).run();
}

}  // namespace ohb::learner
