// What tells one model from another: the content of its files.
#pragma once

#include <filesystem>
#include <string>

namespace ohb {

/// SHA-256 of all that pictures of a MODEL folder are made of: model.xml (which holds the version that wrote
/// it), mesh.obj, faces.bin and the maps that model.xml names, but displacement, which no picture shows.
/// 64 hexadecimal digits. The files are read once, in parallel. Throws InputError as read_model.
std::string model_identity(const std::filesystem::path& folder);

}  // namespace ohb
