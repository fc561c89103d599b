// A folder of assets in MakeHuman's formats: people as tubes, small enough to be made in a test.
#pragma once

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace ohb::people {

class TinyAssets {
 public:
  static constexpr int kSides = 12, kRings = 17;  // rings 1 dm apart

  explicit TinyAssets(const std::filesystem::path& folder) : folder_(folder) {
    write_base();
    write(
        "rigs/default.mhskel",
        R"({"bones": {"root": {"head": "a", "tail": "b", "parent": null}}, "joints": {"a": [0], "b": [12]}})");
    write("rigs/default_weights.mhw", R"({"weights": {"root": [[0, 1.0]]}})");
    write("poses/standing01.bvh",
          "HIERARCHY\nROOT root\n{\nOFFSET 0 0 0\nCHANNELS 3 Xrotation Yrotation Zrotation\nEnd Site\n{\n"
          "OFFSET 0 1 0\n}\n}\nMOTION\nFrames: 1\nFrame Time: 1\n0 0 0\n");
    write("skins/young_caucasian_female/young_caucasian_female.mhmat", "diffuseColor .8 .6 .5\n");
    write("skins/young_caucasian_male/young_caucasian_male.mhmat", "diffuseColor .7 .5 .4\n");
    write("eyes/materials/brown.mhmat", "diffuseColor .3 .2 .1\n");
    tube("eyes/high-poly/high-poly", 15, 17, -.3f);
    tube("hair/short01/short01", 15, 17, .1f);
    tube("hair/short03/short03", 14, 17, .1f);
    tube("clothes/female_casualsuit01/female_casualsuit01", 1, 13, .15f);
    tube("clothes/male_casualsuit01/male_casualsuit01", 1, 13, .15f);
    tubes("clothes/shoes01/shoes01", {{0, 2, .1f}, {1, 4, .2f}});  // with socks above the shoes
  }

  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

 private:
  static std::string ring_vertex(int ring, int side, float radius) {
    const double angle = 2 * 3.14159265358979 * side / kSides;
    return std::to_string(radius * std::sin(angle)) + " " + std::to_string(ring) + " " +
           std::to_string(radius * std::cos(angle));
  }

  /// Quads between rings; UVs unrolled, faces outwards. Corners count on from those that are there.
  static std::string tube_faces(int rings, int vertices_before = 0, int uvs_before = 0) {
    std::string text;
    for (int ring = 0; ring < rings; ++ring)
      for (int side = 0; side <= kSides; ++side)
        text += "vt " + std::to_string(.9 * side / kSides) + " " + std::to_string(.9 * ring / rings) + "\n";
    text += "g body\n";
    for (int ring = 0; ring + 1 < rings; ++ring)
      for (int side = 0; side < kSides; ++side) {
        const auto corner = [&](int r, int s) {
          return " " + std::to_string(vertices_before + r * kSides + s % kSides + 1) + "/" +
                 std::to_string(uvs_before + r * (kSides + 1) + s + 1);
        };
        text += "f" + corner(ring, side) + corner(ring, side + 1) + corner(ring + 1, side + 1) +
                corner(ring + 1, side) + "\n";
      }
    return text;
  }

  void write_base() const {
    std::string text;
    for (int ring = 0; ring < kRings; ++ring)
      for (int side = 0; side < kSides; ++side) text += "v " + ring_vertex(ring, side, 1) + "\n";
    text += tube_faces(kRings);
    text += "g joint-ground\nf 1/1 2/2 3/3 4/4\n";
    write("3dobjs/base.obj", text);
  }

  struct Tube {
    int first, last;  // rings
    float outside;    // dm from the body
  };
  void tube(const std::string& name, int first, int last, float outside) const {
    tubes(name, {{first, last, outside}});
  }
  /// A thing of separate pieces around the body.
  void tubes(const std::string& name, const std::vector<Tube>& pieces) const {
    std::string mesh,
        anchors = "obj_file " + name.substr(name.rfind('/') + 1) + ".obj\nmaterial m.mhmat\nverts 0\n";
    int vertices = 0, uvs = 0;
    for (const Tube& piece : pieces) {
      for (int ring = piece.first; ring < piece.last; ++ring)
        for (int side = 0; side < kSides; ++side) {
          mesh += "v " + ring_vertex(ring, side, 1 + piece.outside) + "\n";
          const std::string vertex = std::to_string(ring * kSides + side);
          const double angle = 2 * 3.14159265358979 * side / kSides;
          anchors += vertex + " " + vertex + " " + vertex + " 1 0 0 " +
                     std::to_string(piece.outside * std::sin(angle)) + " 0 " +
                     std::to_string(piece.outside * std::cos(angle)) + "\n";
        }
      mesh += tube_faces(piece.last - piece.first, vertices, uvs);
      vertices += (piece.last - piece.first) * kSides;
      uvs += (piece.last - piece.first) * (kSides + 1);
    }
    write(name + ".obj", mesh);
    write(name + ".mhclo", anchors);
    write(name.substr(0, name.rfind('/')) + "/m.mhmat", "diffuseColor .5 .5 .5\n");
  }

  std::filesystem::path folder_;
};

}  // namespace ohb::people
