// A command's output that is one file.
#pragma once

#include <filesystem>
#include <vector>

namespace ohb::learner {

/// Throws InputError where `output` is one of the `inputs` (links are followed; what does not exist counts
/// for nothing), is a folder, a device or a pipe, or belongs to another output's folder (check_not_owned).
void check_output_file(const std::filesystem::path& output, const std::vector<std::filesystem::path>& inputs);

}  // namespace ohb::learner
