// Weights files of networks that learned nothing.
#pragma once

#include <string>
#include <vector>

#include "learner/checkpoint.h"
#include "tests/support/test_files.h"

namespace ohb {

/// Untrained weights of the three priors (and finetune) at 16 px, as files.
inline std::vector<std::filesystem::path> weights_in(const TemporaryFolder& folder, bool finetune) {
  std::vector<std::filesystem::path> files;
  for (const learner::Task task : learner::kTasks) {
    if (task == learner::Task::kFinetune && !finetune) continue;
    torch::manual_seed(3);
    const learner::Network network = learner::make_network(task, 0.125);
    const auto file = folder / (std::string(learner::name_of(task)) + ".safetensors");
    learner::save_weights(file,
                          {{"format", 1},
                           {"task", learner::name_of(task)},
                           {"width", 0.125},
                           {"size_px", 16},
                           {"step", 0},
                           {"trained_on", {"person0"}},
                           {"held_out", {"person1"}}},
                          network);
    files.push_back(file);
  }
  return files;
}

}  // namespace ohb
