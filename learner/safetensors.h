// Named tensors in one file, in the safetensors layout (huggingface.co/docs/safetensors), so that any program
// can read the weights: 8 bytes of header length (little-endian), a JSON header of names, types, shapes and
// byte ranges, then the numbers. `__metadata__` holds strings.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "learner/torch.h"

namespace ohb::learner {

struct TensorFile {
  std::vector<std::pair<std::string, torch::Tensor>>
      tensors;  // float32, half or int64; those read are on the CPU
  std::map<std::string, std::string> metadata;
};

/// Atomic: a crash or a full disk leaves the older file. Throws as write_file_atomically.
void write_tensors(const std::filesystem::path& file, const TensorFile& content);

/// Nothing in the file is trusted: throws InputError if it is truncated, if the header is no JSON of the
/// layout, longer than 100 MB or than the file, if a byte range is outside the data, overlaps another or does
/// not fit its shape and type, or if bytes are left over. Half is returned as half.
TensorFile read_tensors(const std::filesystem::path& file);

}  // namespace ohb::learner
