// Where this checkout lies. Only paths.cpp, which CMake writes, holds the paths, so that the compiler cache
// knows every other file of the tests again when the checkout is in another folder.
#pragma once

#include <string>

namespace ohb {

/// The absolute path of a file of the checkout, for example source_path("assets/wardrobe.json").
std::string source_path(const std::string& name);

/// The absolute path of a built program, for example program_path("humanmaterial").
std::string program_path(const std::string& name);

/// The absolute path of a file or folder of the optional data (CMake cache variable OHB_SHARED_DATA), there
/// or not.
std::string shared_data_path(const std::string& name);

}  // namespace ohb
