// Readers under random damage, with fixed seeds.
#include <random>

#include "dataset/commands/inspect.h"
#include "dataset/model/scan.h"
#include "tests/support/compressed_gltf.h"
#include "tests/support/fbx_files.h"
#include "tests/support/picture_files.h"
#include "tests/support/scan_files.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace commands;
namespace {

/// Whatever bytes change, a reader loads the scan or throws InputError, in bounded time and memory.
void fuzz(const std::string& name, const std::string& whole, int rounds, uint32_t seed,
          const TemporaryFolder& folder) {
  std::mt19937 random(seed);
  const auto below = [&random](size_t n) { return static_cast<size_t>(random() % n); };
  size_t loaded = 0;
  for (int i = 0; i < rounds; ++i) {
    std::string bytes = whole;
    for (size_t flips = 1 + below(4); flips > 0; --flips) {
      const size_t at = below(bytes.size());
      static const std::string edges("\0\xff\x7f\x80 0-9.{}[]\"", 14);
      bytes[at] = random() % 2 ? static_cast<char>(random()) : edges[below(edges.size())];
    }
    if (random() % 8 == 0) bytes.resize(below(bytes.size()));
    const std::filesystem::path file = write_bytes(folder / name, bytes);
    try {
      const Scan scan = read_scan(file);
      EXPECT_GE(triangulate(scan).size(), scan.face_count());
      if (loaded % 16 == 0) inspect_scan(scan, "cm");
      ++loaded;
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
  EXPECT_GT(loaded, 0u) << name << ": every mutation was refused; the fuzzing does not reach the reader";
}

TEST(FuzzedScans, Obj) {
  const TemporaryFolder folder;
  write_small_png(folder / "p.png");
  write_bytes(folder / "m.mtl", "newmtl a\nKd 1 1 1\nmap_Kd p.png\n");
  fuzz("scan.obj",
       "mtllib m.mtl\ng body\nusemtl a\n" + std::string(kQuadObj) + "vn 0 0 1\nf -1/-1/1 -2/-2/1 -3/-3/1\n",
       400, 1, folder);
  fuzz("scan.obj", "#MRGB ff0000ff00ff00ff\nv 0 0 0 1 0 0\nv 9e5 0 0 0 1 0\nv 9e5 1 0 0 0 1\nf 1 2 3\n", 300,
       8, folder);
}

TEST(FuzzedScans, Mtl) {
  const TemporaryFolder folder;
  write_small_png(folder / "p.png", 4);
  write_bytes(folder / "scan.obj", "mtllib m.mtl\nusemtl a\n" + std::string(kQuadObj));
  const std::string mtl =
      "newmtl a\nKd 1 1 1\nd .5\nmap_Kd -s 2 1 1 -o .5 0 -clamp on p.png\nTr 0\nmap_d -imfchan m p.png\nbump "
      "-bm 1 p.png\n";
  std::mt19937 random(9);
  for (int i = 0; i < 300; ++i) {
    std::string bytes = mtl;
    for (int flips = 0; flips < 2; ++flips) bytes[random() % bytes.size()] = static_cast<char>(random());
    write_bytes(folder / "m.mtl", bytes);
    try {
      read_scan(folder / "scan.obj");
    } catch (const InputError&) {
    }
  }
}

TEST(FuzzedScans, Glb) {
  const TemporaryFolder folder;
  write_small_png(folder / "p.png", 4);
  const std::string png = read_file(folder / "p.png");
  fuzz("scan.glb", glb_of(quad_glb_json(png.size()), quad_glb_binary(png)), 500, 3, folder);
}

TEST(FuzzedScans, GlbOfRigsAndCompressedData) {
  const TemporaryFolder folder;
  write_small_png(folder / "p.png", 4);
  GlbBuilder rig = skinned_glb();
  rig.colour_info() = rig.add_picture(read_file(folder / "p.png"), {{"wrapS", 33648}, {"wrapT", 33071}});
  rig.colour_info()["extensions"]["KHR_texture_transform"] = {{"scale", {3, 2}}, {"rotation", 1}};
  rig.material()["alphaMode"] = "MASK";
  rig.primitive()["attributes"]["COLOR_0"] =
      rig.add<uint8_t>(std::vector<uint8_t>(16, 99), "VEC4", 5121, true);
  rig.primitive()["targets"] = {{{"POSITION", rig.add(std::vector<float>(12, 1), "VEC3", 5126)}}};
  rig.json["meshes"][0]["weights"] = {0.5};
  rig.json["accessors"][0]["sparse"] = {{"count", 1},
                                        {"indices", {{"bufferView", 2}, {"componentType", 5123}}},
                                        {"values", {{"bufferView", 0}}}};
  fuzz("scan.glb", rig.bytes(), 600, 7, folder);
  fuzz("scan.glb", meshopt_glb().bytes(), 600, 8, folder);
  fuzz("scan.glb", draco_glb().bytes(), 600, 9, folder);
}

TEST(FuzzedScans, Fbx) {
  const TemporaryFolder folder;
  fuzz("scan.fbx", quad_fbx(), 500, 4, folder);
  fuzz("scan.fbx", ascii_quad_fbx(), 300, 5, folder);
  write_small_png(folder / "p.png");
  fuzz("scan.fbx",
       ascii_quad_fbx6(
           "\t\t\tProperty: \"smile\", \"Shape\", \"A+N\",50\n",
           "\tTexture: \"Texture::t\", \"\" {\n\t\tFileName: \"p.png\"\n\t\tModelUVScaling: 2,2\n\t}\n",
           "\tConnect: \"OO\", \"Texture::t\", \"Model::body\"\n"),
       400, 7, folder);
}

TEST(FuzzedScans, Pictures) {
  const TemporaryFolder folder;
  const std::string small = small_jpeg();
  std::mt19937 random(6);
  for (const auto& [name, whole] : {std::pair<std::string, std::string>("p.png", picture_bytes("p.png", 16)),
                                    {"p.exr", picture_bytes("p.exr", 16)},
                                    {"p.jpg", small}})
    for (int i = 0; i < 150; ++i) {
      std::string bytes = whole;
      for (int flips = 0; flips < 3; ++flips) bytes[random() % bytes.size()] = static_cast<char>(random());
      try {
        const Image image = read_image(write_bytes(folder / name, bytes));
        EXPECT_EQ(image.values.size(),
                  static_cast<size_t>(image.width_px) * image.height_px * image.channels);
      } catch (const InputError&) {
      }
    }
}

}  // namespace
}  // namespace ohb
