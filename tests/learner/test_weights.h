// Weights files of networks that learned nothing.
#pragma once

#include <string>
#include <vector>

#include "learner/checkpoint.h"
#include "tests/support/test_files.h"

namespace ohb {

/// Untrained weights of these networks at 16 px, as files.
inline std::vector<std::filesystem::path> weights_of(const std::vector<learner::Task>& tasks,
                                                     const TemporaryFolder& folder) {
  std::vector<std::filesystem::path> files;
  for (const learner::Task task : tasks) {
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

/// Of the three priors (and finetune).
inline std::vector<std::filesystem::path> weights_in(const TemporaryFolder& folder, bool finetune) {
  std::vector<learner::Task> tasks(learner::kPriorTasks.begin(), learner::kPriorTasks.end());
  if (finetune) tasks.push_back(learner::Task::kFinetune);
  return weights_of(tasks, folder);
}

}  // namespace ohb
