// A scanned person on disk: OBJ, MTL, JPEG, labels and JSON, named as the open set of humans is.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "dataset/people/scan_bake.h"

namespace ohb::people {

/// Writes <name>_scan.obj, .mtl, .jpg, .labels.txt and .json into `folder`. `extra` is added to the JSON.
/// Throws as write_file_atomically.
void write_scan(const std::filesystem::path& folder, const std::string& name, const ScannedPerson& scan,
                const nlohmann::json& extra);

/// A small picture of the person by the project's renderer, linear to sRGB, on grey.
ByteImage preview(const ScannedPerson& scan, int size_px);

}  // namespace ohb::people
