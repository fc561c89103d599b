#include "learner/cli/commands.h"

#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <thread>

#include "learner/torch.h"

namespace ohb::learner {

void use_threads(int threads) {
  // libtorch would count the cores, not the processors, and take one thread on a machine of two.
  torch::set_num_threads(threads > 0 ? threads
                                     : static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
  if (threads <= 0) return;
  // Until the end of the process, which is the command's.
  static auto* const limit = new tbb::global_control(tbb::global_control::max_allowed_parallelism, threads);
  static_cast<void>(limit);
}

void add_device_option(CLI::App& command, std::string& device) {
  command
      .add_option("--device", device,
                  "where: cpu, cuda, cuda:N (the GPU of that number), or auto: a GPU if there is one")
      ->capture_default_str();
}

// Each of these is in its own cmd_<name>.cpp.
void add_train_command(CLI::App& app, Commands& commands);
void add_evaluate_command(CLI::App& app, Commands& commands);
void add_stress_command(CLI::App& app, Commands& commands);
void add_chart_command(CLI::App& app, Commands& commands);
void add_estimate_command(CLI::App& app, Commands& commands);
void add_relight_command(CLI::App& app, Commands& commands);
void add_torchscript_command(CLI::App& app, Commands& commands);

void add_commands(CLI::App& app, Commands& commands) {
  add_train_command(app, commands);
  add_evaluate_command(app, commands);
  add_stress_command(app, commands);
  add_chart_command(app, commands);
  add_estimate_command(app, commands);
  add_relight_command(app, commands);
  add_torchscript_command(app, commands);
}

}  // namespace ohb::learner
