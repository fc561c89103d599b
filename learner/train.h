// Training of a network.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "learner/checkpoint.h"
#include "learner/priors.h"
#include "learner/profile.h"
#include "learner/task.h"

namespace ohb::learner {

/// What the finetuning model gets as guidance while it trains.
enum class Guidance {
  kTruth,  // the ground-truth maps, as in the paper
  kPriors  // the trained priors' estimates, as it gets when it runs
};

struct TrainOptions {
  Task task = Task::kGeometry;
  std::filesystem::path data, run;
  std::filesystem::path from;  // weights or run to begin with; empty: random ones
  bool resume = false;
  std::vector<std::string> held_out;  // people; empty: split_people chooses
  double width = 0.25;
  int size_px = 128, batch = 1;  // of all ranks together
  int64_t steps = 0;             // 0: `epochs` passes over the views
  int epochs = 100;
  double learning_rate = 1e-4, weight_decay = 0.01, clip = 1;
  int64_t warmup = 1000;  // steps of linear rise; at most a tenth of all
  bool cosine = false;    // then falls to 1e-6 at the last step; else constant, as in the paper
  double render_weight = 1, control_roughness = kGeometryRoughness;
  bool linear_render = false;  // plain L1 of radiance, as in the paper, instead of ln(1 + x)
  bool mirror = false;         // half of the examples with left and right exchanged (not in the paper)
  bool balanced = false;       // see losses_of
  bool recolour = false;       // half of the examples with other colours (not in the paper)
  bool snapshots = false;      // pictures as cameras and matting give them (not in the paper)
  bool parts = false;          // parts of people: windows of samples larger than size_px (not in the paper)
  bool mix_lights = false;     // more lights than were rendered: see mixed_light (not in the paper)
  bool average = false;        // the weights are averages over the last steps (not in the paper)
  bool residual = false;       // finetune: see JointNetImpl::refines (not in the paper)
  Guidance guidance = Guidance::kTruth;
  std::vector<std::filesystem::path> priors;  // for Guidance::kPriors, as PriorSet takes them
  uint64_t seed = 1;
  torch::Device device = torch::kCPU;   // a run may be resumed on another
  int threads = 0, loader_threads = 1;  // 0: all processors
  int64_t checkpoint_every = 500, log_every = 10;
  int keep = 2;          // checkpoints
  bool quiet = false;    // no progress line
  bool profile = false;  // say what the steps' time went to
};

struct TrainReport {
  int64_t first_step = 0, steps = 0, skipped = 0;
  double first_loss = 0, last_loss = 0;  // means over the first and the last tenth of this call's steps
  double seconds = 0, data_wait_s = 0;
  bool is_first_rank = true;         // of Ranks; the others write nothing
  std::filesystem::path weights;     // of the first rank
  std::vector<ProfileLine> profile;  // of this call's steps but the first, if asked for
};

/// Trains until the last step and writes RUN/weights.safetensors; on the way RUN/step_*.safetensors and
/// RUN/log.jsonl, one line of JSON an event. A function of options and data: two runs on the same number of
/// threads are equal bit for bit on the CPU, interrupted and resumed or not.
///
/// A step whose loss or gradient isn't finite is left out and logged with its samples' names; ten in a row
/// are an InputError.
/// Several processes may train together (Ranks): the batch is that of all of them, each takes its part, and
/// only the first writes. Same batch, same run, on any number of ranks, up to rounding. Throws InputError:
/// bad options or data, `from` of another network, ranks that disagree, a run that exists (without `resume`)
/// or that was started with other options (with it); TryAgainError: disk full, another rank that ended, or
/// SIGINT or SIGTERM, after saving.
TrainReport train(const TrainOptions& options);

/// Throws InputError, naming the option, for values that make no sense together.
void check_train_options(const TrainOptions& options);

/// Learning rate of step `step` of `steps`, counted from 1.
double learning_rate_at(const TrainOptions& options, int64_t step, int64_t steps);

}  // namespace ohb::learner
