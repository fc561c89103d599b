// Checkpoints of a run: weights, optimiser moments and what the run is, one file each, written atomically.
// Files do not know devices: tensors are written from, and loaded onto, whichever they are on.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "learner/adamw.h"
#include "learner/task.h"

namespace ohb::learner {

/// RUN/step_<kkkkkkkk>.safetensors holds model.<parameter>, adam.first.<parameter>, adam.second.<parameter>
/// and, in runs that average, average.<parameter> in float32; metadata "humanmaterial" is the header as JSON
/// text. RUN/weights.safetensors, written at the end of training, holds model.<parameter> in half.
///
/// The header: format 1, task, width, size_px, step, every training option, the names of the people trained
/// on and held out, the version.
constexpr int kCheckpointFormat = 1;
constexpr const char* kWeightsName = "weights.safetensors";

std::filesystem::path checkpoint_file(const std::filesystem::path& run, int64_t step);

/// Throws as write_file_atomically. Of older checkpoints in the run the last `keep` - 1 stay.
void save_checkpoint(const std::filesystem::path& run, const nlohmann::json& header, AdamW& optimiser,
                     int keep);

/// The weights alone, in half.
void save_weights(const std::filesystem::path& file, const nlohmann::json& header, const Network& network);

/// The newest checkpoint in the run that is there; none if there is none or no such folder.
std::optional<std::filesystem::path> newest_checkpoint(const std::filesystem::path& run);

/// The header. Throws InputError if the file is no checkpoint of this format.
nlohmann::json read_checkpoint_header(const std::filesystem::path& file);

/// Copies weights and moments into the optimiser's parameters and states, and returns the header. Throws
/// InputError if a tensor is missing, left over, of another shape, NaN or infinite: then nothing is changed.
nlohmann::json load_checkpoint(const std::filesystem::path& file, AdamW& optimiser);

struct LoadedNetwork {
  Network network;
  nlohmann::json header;
  std::filesystem::path file;
};
/// A network with its weights (their average, where there is one) from a checkpoint, a weights file, or a
/// run's folder (its newest checkpoint, else its weights). Throws InputError as load_checkpoint.
LoadedNetwork load_network(const std::filesystem::path& file_or_run);

}  // namespace ohb::learner
