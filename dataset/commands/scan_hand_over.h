// A scan for painting tools, as the program has read it: the same faces in the same order, whatever the
// format.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "dataset/model/scan.h"

namespace ohb::commands {

/// Writes `mesh.bin` into `folder` (made if need be), one after the other without gaps, in the byte order of
/// the machine: positions (float x, y, z; the scan's unit and axes), face_begin (uint32, faces + 1), corners'
/// positions (uint32), corners' UVs (float u, v; v up; 0, 0 where there is none), material and group of each
/// face (uint16). Pictures that the scan's file embeds, or that it shows moved, go into the folder too. Gives
/// {"file", "positions", "faces", "corners", "materials": [{"name", "picture", "color"}], "groups": [...]}:
/// "picture" is the path of the diffuse picture or "", "color" linear Rec. 709.
/// Throws InputError or TryAgainError for a folder that cannot be written or a picture that cannot be read.
nlohmann::ordered_json hand_over_scan(const Scan& scan, const std::filesystem::path& folder);

}  // namespace ohb::commands
