// A scan of two triangles with all that label and bake need of it, in a folder of its own.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>
#include <string>

#include "dataset/commands/bake_scan.h"
#include "dataset/commands/label.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/data_files.h"
#include "tests/support/scan_files.h"
#include "tests/support/test_files.h"

namespace ohb {

/// A person-high square of two triangles with a picture and a normal map, in `folder`.
inline void write_square(const std::filesystem::path& folder) {
  write_bytes(folder / "square.obj",
              "mtllib square.mtl\nusemtl shirt\nv 0 0 0\nv 150 0 0\nv 150 150 0\nv 0 150 0\n"
              "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n");
  write_bytes(folder / "square.mtl", "newmtl shirt\nmap_Kd p.png\nnorm n.exr\n");
  write_small_png(folder / "p.png");
  Image normal(8, 8, 3);
  for (int i = 0; i < 64; ++i) normal.values[3 * i + 2] = 1;
  write_exr(folder / "n.exr", {{"n", {"R", "G", "B"}, ExrPart::Type::kHalf, normal}}, {});
}

/// Everything that label and bake of the square need.
struct Square {
  TemporaryFolder folder;
  commands::LabelJob label;
  commands::BakeJob bake;
  Square() {
    write_square(folder.path());
    write_bytes(folder / "faces.txt", "0\n2\n");
    write_bytes(folder / "rules.xml", "<rules default='fabric'/>");
    std::filesystem::copy_file(program_file("assets/materials.xml"), folder / "materials.xml");
    label.scan = bake.scan = folder / "square.obj";
    label.faces = folder / "faces.txt";
    label.output = bake.regions = folder / "regions";
    bake.materials = folder / "materials.xml";
    bake.output = folder / "model";
    bake.quiet = true;
  }
};

/// Files and folders straight in `folder`.
inline size_t entries_of(const std::filesystem::path& folder) {
  return static_cast<size_t>(
      std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator()));
}

/// Replaces the first `from` of a text file, which must be there.
inline void edit(const std::filesystem::path& file, const std::string& from, const std::string& to) {
  std::string content = read_file(file);
  ASSERT_NE(content.find(from), std::string::npos) << file << ": " << from;
  write_bytes(file, content.replace(content.find(from), from.size(), to));
}

}  // namespace ohb
