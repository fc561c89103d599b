#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "dataset/model/json_text.h"
#include "dataset/program/help.h"
#include "dataset/program/option_checks.h"
#include "learner/blas.h"
#include "learner/cli/commands.h"
#include "learner/counts.h"
#include "learner/device.h"
#include "learner/train.h"

namespace ohb::learner {
namespace {

constexpr uint64_t kMostSteps = 1'000'000'000'000;

/// Options by name; what the command line says itself goes before them, and the first of two before the
/// second.
struct Preset {
  const char* name;
  std::vector<std::pair<const char*, const char*>> options;
};
const std::vector<Preset>& presets() {
  static const std::vector<Preset> all = [] {
    const Preset paper = {"paper",
                          {{"--width", "1"},
                           {"--size", "512"},
                           {"--batch", "1"},
                           {"--learning-rate", "1e-4"},
                           {"--linear-render-loss", "true"}}};
    // What the weights that come along were trained with (assets/train_open_weights.sh).
    const Preset best = {"best",
                         {{"--batch", "2"},
                          {"--learning-rate", "5e-4"},
                          {"--render-weight", "0"},
                          {"--average", "true"},
                          {"--mirror", "true"},
                          {"--recolour", "true"},
                          {"--snapshots", "true"},
                          {"--parts", "true"},
                          {"--mix-lights", "true"},
                          {"--balanced", "true"},
                          {"--residual", "true"}}};
    // The joint network's: twice the rate of `best`, falling.
    Preset fast = best;
    fast.name = "fast";
    fast.options.insert(fast.options.begin(), {{"--learning-rate", "1e-3"}, {"--cosine", "true"}});
    return std::vector<Preset>{paper, best, fast};
  }();
  return all;
}

void apply_preset(CLI::App& command, const std::string& name) {
  for (const Preset& preset : presets())
    if (preset.name == name)
      for (const auto& [option, value] : preset.options) {
        CLI::Option* of_command = command.get_option(option);
        if (of_command->count() > 0) continue;
        of_command->add_result(value);
        of_command->run_callback();
      }
}

struct Arguments {
  learner::TrainOptions train;
  std::string task, data, output, from, preset, guidance = "truth", device = "auto";
  std::vector<std::string> priors;
};

void print_size(const learner::TrainOptions& o) {
  const learner::Network network = learner::make_network(o.task, o.width, o.residual);
  const int64_t multiplies = learner::multiplies_of(network, o.size_px);
  std::fprintf(stderr, "%s, width %g: %.2f million parameters, %.2f billion multiplies at %d x %d\n",
               learner::name_of(o.task), o.width,
               1e-6 * static_cast<double>(learner::parameter_count(network.module())),
               1e-9 * static_cast<double>(multiplies), o.size_px, o.size_px);
}

int run_train(Arguments arguments, const CommonOptions& common) {
  learner::TrainOptions& o = arguments.train;
  o.task = learner::task_from_name(arguments.task);
  o.data = arguments.data;
  o.run = arguments.output;
  o.from = arguments.from;
  o.guidance = arguments.guidance == "priors" ? learner::Guidance::kPriors : learner::Guidance::kTruth;
  o.priors.assign(arguments.priors.begin(), arguments.priors.end());
  o.seed = common.seed;
  o.threads = common.threads;
  o.device = device_of(arguments.device);
  use_threads(common.threads);
  learner::warn_of_slow_blas();
  learner::check_train_options(o);
  print_size(o);
  const learner::TrainReport report = learner::train(o);
  if (!report.is_first_rank) return 0;
  const int64_t done = report.steps - report.first_step;
  const double wait = report.seconds > 0 ? report.data_wait_s / report.seconds : 0;
  if (common.json) {
    nlohmann::json json = {{"weights", report.weights.string()},
                           {"first_step", report.first_step},
                           {"steps", report.steps},
                           {"skipped", report.skipped},
                           {"first_loss", report.first_loss},
                           {"last_loss", report.last_loss},
                           {"seconds", report.seconds},
                           {"data_wait_share", wait}};
    if (o.profile) json["profile"] = json_of(report.profile);
    std::printf("%s\n", json_text(json, 2).c_str());
    return 0;
  }
  if (o.profile) std::printf("%s", table_of(report.profile, done - 1).c_str());
  std::printf("%s: %lld steps in %.1f s (%.1f %% waiting for data), loss %.4f at first, %.4f at last\n",
              report.weights.c_str(), static_cast<long long>(done), report.seconds, 100 * wait,
              report.first_loss, report.last_loss);
  return 0;
}

void add_finetuning(CLI::App& command, Arguments& arguments) {
  command.add_option("--guidance", arguments.guidance, "finetune: maps to refine while it trains")
      ->check(CLI::IsMember({"truth", "priors"}))
      ->capture_default_str();
  command.add_option("--priors", arguments.priors,
                     "finetune with --guidance priors: runs or weights of the three priors, or of joint");
  command.add_flag("--residual", arguments.train.residual,
                   "finetune: the joint network, which changes its guidance (the paper puts out maps)");
}

void add_schedule(CLI::App& command, learner::TrainOptions& o) {
  command.add_option("--width", o.width, "width of the network; 1 is the paper's")
      ->check(program::number_within(0.05, 4))
      ->capture_default_str();
  command
      .add_option("--size", o.size_px, "pixels of a side, a multiple of 16 that divides the samples' size")
      ->check(program::whole_within(16, 8192))
      ->capture_default_str();
  command.add_option("--batch", o.batch, "samples a step, of all ranks together")
      ->check(program::whole_within(1, 65536))
      ->capture_default_str();
  command.add_option("--steps", o.steps, "steps in all (default: by --epochs)")
      ->check(program::whole_within(1, kMostSteps));
  command.add_option("--epochs", o.epochs, "passes over the training views")
      ->check(program::whole_within(1, 1'000'000))
      ->capture_default_str();
  command.add_option("--learning-rate", o.learning_rate, "of AdamW")
      ->check(program::number_within(1e-12, 10))
      ->capture_default_str();
  command.add_option("--warmup", o.warmup, "steps over which it rises; a tenth of all at most")
      ->check(program::whole_within(0, kMostSteps))
      ->capture_default_str();
  command.add_flag("--cosine", o.cosine, "let it fall to 1e-6 by the last step (the paper holds it)");
}

void add_losses(CLI::App& command, learner::TrainOptions& o) {
  command.add_option("--render-weight", o.render_weight, "weight of the rendering loss")
      ->check(program::number_within(0, 1e6))
      ->capture_default_str();
  command
      .add_option("--control-roughness", o.control_roughness,
                  "geometry, joint: roughness of all surfaces in the rendering loss of normals")
      ->check(program::number_within(0.02, 1))
      ->capture_default_str();
  command.add_flag("--linear-render-loss", o.linear_render,
                   "L1 of radiance, as in the paper, not of ln(1 + radiance)");
  command.add_flag("--mirror", o.mirror,
                   "exchange left and right in half of the examples (the paper does not)");
  command.add_flag("--balanced", o.balanced,
                   "roughness, specular and sss count alike, by absolute and squared difference");
  command.add_flag("--recolour", o.recolour,
                   "give half of the examples other colours (the paper does not): for few people");
  command.add_flag("--snapshots", o.snapshots,
                   "exposure, white balance, tones, blur, noise and mattes as photographs have them");
  command.add_flag("--parts", o.parts,
                   "half bodies and closer: windows of samples larger than --size (the paper does not)");
  command.add_flag("--mix-lights", o.mix_lights,
                   "two of a sample's lights at once, in other colours (the paper does not)");
  command.add_flag("--average", o.average,
                   "give the mean of the weights over the last 2000 steps (the paper does not)");
}

void add_bookkeeping(CLI::App& command, Arguments& arguments) {
  learner::TrainOptions& o = arguments.train;
  add_device_option(command, arguments.device);
  command.add_option("--checkpoint-every", o.checkpoint_every, "steps between checkpoints")
      ->check(program::whole_within(1, kMostSteps))
      ->capture_default_str();
  command.add_option("--log-every", o.log_every, "steps between log lines")
      ->check(program::whole_within(1, kMostSteps))
      ->capture_default_str();
  command.add_flag("--profile", o.profile, "say at the end what a step's time went to");
  command.add_option("--loader-threads", o.loader_threads, "threads that read samples")
      ->check(program::whole_within(1, 256))
      ->capture_default_str();
}

}  // namespace

void add_train_command(CLI::App& app, Commands& commands) {
  CLI::App* command = app.add_subcommand("train", "Trains a network on rendered samples");
  auto arguments = std::make_shared<Arguments>();
  command
      ->add_option("MODEL", arguments->task,
                   "geometry, albedo, rss, finetune, or joint, which estimates all maps")
      ->required();
  command->add_option("--data", arguments->data, "folder with a folder of views a person")->required();
  command->add_option("-o,--output", arguments->output, "folder of the run")->required();
  command->add_flag("--resume", arguments->train.resume,
                    "go on from the run's last checkpoint, if there is one");
  command->add_option("--from", arguments->from,
                      "weights or run to begin with, of this model and width (default: random ones)");
  command->add_option("--hold-out", arguments->train.held_out,
                      "person to keep for testing; may be repeated (default: every fourth)");
  add_finetuning(*command, *arguments);
  std::vector<std::string> names;
  for (const Preset& preset : presets()) names.emplace_back(preset.name);
  command->add_option("--preset", arguments->preset, "options by name; those given too go before it")
      ->check(CLI::IsMember(names));
  add_schedule(*command, arguments->train);
  add_losses(*command, arguments->train);
  add_bookkeeping(*command, *arguments);
  add_common_options(*command, commands.common);
  add_seed_option(*command, commands.common);
  command->footer(program::help_footer(
      {"humanmaterial train geometry --data dataset --size 128 --width 0.25 --epochs 20 -o runs/geometry",
       "humanmaterial train joint --preset fast --steps 24000 --data dataset -o runs/joint",
       "humanmaterial train finetune --data dataset --guidance priors --priors runs/geometry runs/albedo "
       "runs/rss -o runs/finetune"},
      "SIGINT and SIGTERM save and exit with 75; --resume goes on, bit for bit as if nothing had happened.\n"
      "RANK, WORLD_SIZE, MASTER_ADDR and MASTER_PORT, as torchrun sets them, make several processes one "
      "training."));
  command->callback([arguments, command, &commands] {
    apply_preset(*command, arguments->preset);
    commands.run = [arguments, &commands] { return run_train(*arguments, commands.common); };
  });
}

}  // namespace ohb::learner
