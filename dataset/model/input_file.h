// What a path must be to be read: pipes and devices would let a reader wait for ever.
#pragma once

#include <filesystem>

namespace ohb {

/// Throws InputError unless `file` is a regular file (or a link to one) that may be read: there is none, it
/// is a folder, a pipe, a device, its name is too long, or its permissions forbid it.
void expect_input_file(const std::filesystem::path& file);

}  // namespace ohb
