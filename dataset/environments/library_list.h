// envmaps.xml as text.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/environments/library.h"

namespace ohb::environments {

/// The same for equal entries.
std::string library_list_text(const std::vector<LibraryEntry>& entries);

/// Throws InputError with the line of what is wrong.
std::vector<LibraryEntry> read_library_list(const std::filesystem::path& file);

}  // namespace ohb::environments
