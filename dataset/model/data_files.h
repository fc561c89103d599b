// Files that come with the program: materials.xml and the like (assets/...), Blender scripts
// (blender_addon/...).
#pragma once

#include <filesystem>

namespace ohb {

/// The file of that relative name ("assets/materials.xml"), looked for in $OPENHUMANBRDF_DATA, in
/// ../share/openhumanbrdf beside an installed program, and in the folders above the program (a build tree
/// inside the source folder). Throws InputError if it is nowhere.
std::filesystem::path program_file(const std::filesystem::path& relative);

}  // namespace ohb
