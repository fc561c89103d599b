#include "learner/output_file.h"

#include "dataset/model/atomic_folder.h"
#include "dataset/model/error.h"

namespace ohb::learner {

void check_output_file(const std::filesystem::path& output,
                       const std::vector<std::filesystem::path>& inputs) {
  std::error_code ignored;
  const std::filesystem::file_status there = std::filesystem::status(output, ignored);
  if (std::filesystem::exists(there) && !std::filesystem::is_regular_file(there))
    throw InputError(output.string(), "-o", "is a folder, a device or a pipe, and a file would be written",
                     "name a file");
  for (const std::filesystem::path& input : inputs)
    if (std::filesystem::equivalent(input, output, ignored))
      throw InputError(output.string(), "-o", "is read by this command", "choose another name");
  check_not_owned(output);
}

}  // namespace ohb::learner
