// What --version prints.
#pragma once

#include <string>

namespace ohb {

/// The program's and its libraries' versions and the processor features in use, one a line.
std::string version_text();

/// Throws InputError if this processor lacks instructions that the renderer was compiled for.
void check_processor();

}  // namespace ohb
