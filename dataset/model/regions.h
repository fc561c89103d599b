// The material classes and a scan's class of each face.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace ohb {

enum MaterialClass : uint8_t { kSkin = 0, kHair = 1, kFabric = 2, kLeather = 3, kUnlabelled = 255 };
constexpr int kClassCount = 4;
constexpr std::array<const char*, kClassCount> kClassNames = {"skin", "hair", "fabric", "leather"};
/// As pictures of the classes show them, linear.
constexpr std::array<std::array<float, 3>, kClassCount> kClassColours = {
    {{0.93f, 0.68f, 0.55f}, {0.45f, 0.25f, 0.12f}, {0.27f, 0.51f, 0.79f}, {0.85f, 0.25f, 0.22f}}};

/// "skin, hair, fabric or leather".
std::string class_list(const std::string& between = ", ", const std::string& last = " or ");

/// The class of that name, or kUnlabelled if there is none.
MaterialClass class_from_name(const std::string& name);

/// Class of each face of a scan, in source face order.
struct Regions {
  std::vector<uint8_t> face_class;  // MaterialClass
  std::string scan_sha256;          // of the scan's mesh file; guards against another mesh's labels
  std::string up = {};              // as turn_up (scan_unit.h): the axes in which it was labelled
};

/// REGIONS on disk is a folder: regions.xml (conventions, counts, scan hash), faces.txt (one class index a
/// line in source face order), index maps and a report as the label command writes them.
void write_regions(const std::filesystem::path& folder, const Regions& regions);
/// Throws InputError for a missing or malformed folder.
Regions read_regions(const std::filesystem::path& folder);

/// Finished per-face classes: one index a line. `classes` names what each index means (default: ours).
/// Throws InputError naming the line for anything that is not an index, and for a wrong number of lines.
std::vector<uint8_t> read_face_classes(const std::filesystem::path& file, size_t face_count,
                                       const std::vector<std::string>& classes);

}  // namespace ohb
