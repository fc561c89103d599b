// Kinds of FBX files that users bring and that went wrong: each has its right value here.
#include <openssl/evp.h>

#include <cmath>

#include "dataset/model/atomic_file.h"
#include "dataset/model/colour.h"
#include "dataset/model/scan.h"
#include "tests/support/fbx_files.h"
#include "tests/support/scan_files.h"
#include "tests/support/test_files.h"

namespace ohb {
namespace {

bool is_noted(const Scan& scan, const std::string& part) {
  for (const std::string& note : scan.notes)
    if (note.find(part) != std::string::npos) return true;
  return false;
}

using Replacements = std::vector<std::pair<std::string, std::string>>;

std::string replaced(std::string text, const Replacements& replacements) {
  for (const auto& [from, to] : replacements) {
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    if (at != std::string::npos) text.replace(at, from.size(), to);
  }
  return text;
}

Scan scan_of_fbx(const TemporaryFolder& folder, const std::string& bytes) {
  return read_scan(write_bytes(folder / "scan.fbx", bytes));
}

/// The ASCII square with these properties of its material, and with a picture that has these of its own.
Scan scan_of_fbx_material(const TemporaryFolder& folder, const std::string& material,
                          const std::string& texture = "", const std::string& slot = "DiffuseColor",
                          int channels = 3) {
  const std::string own = "Material: 30, \"Material::cloth\", \"\" {\n\t}\n";
  std::string with = "Material: 30, \"Material::cloth\", \"\" {\nProperties70: {\n" + material + "}\n}\n";
  Replacements replacements;
  if (!texture.empty()) {
    write_small_png(folder / "p.png", channels);
    with += "Texture: 40, \"Texture::t\", \"\" {\nRelativeFilename: \"p.png\"\nProperties70: {\n" + texture +
            "}\n}\n";
    replacements.push_back({"C: \"OO\",30,20", "C: \"OO\",30,20\nC: \"OP\",40,30, \"" + slot + "\""});
  }
  replacements.push_back({own, with});
  return scan_of_fbx(folder, replaced(ascii_quad_fbx(), replacements));
}

// Blender 3.4: 1 - TransparencyFactor; if that is 0 or 1, Opacity; without it 1 - TransparentColor.
TEST(FaultsFbx, Opacity) {
  const auto number = [](const std::string& name, const std::string& value) {
    return "P: \"" + name + "\", \"Number\", \"\", \"A\"," + value + "\n";
  };
  for (const auto& [properties, opacity] : std::vector<std::pair<std::string, float>>{
           {"", 1},
           {number("TransparencyFactor", "0.95"), .05f},
           {number("Opacity", "0.05"), .05f},
           {number("TransparencyFactor", "1") + number("Opacity", "1"), 1},
           {number("TransparencyFactor", "0") + number("Opacity", "0.3"), .3f},
           {number("TransparencyFactor", "0.4") + number("Opacity", "0.3"), .6f},
           {number("TransparencyFactor", "1") + number("TransparentColor", "0.25,0,0"), .75f}}) {
    const TemporaryFolder folder;
    const Scan scan = scan_of_fbx_material(folder, properties);
    EXPECT_FLOAT_EQ(scan.materials[0].opacity, opacity) << properties;
    EXPECT_EQ(is_noted(scan, "opacity"), opacity < 1) << properties;
  }
  const TemporaryFolder folder;
  const Scan mask =
      scan_of_fbx_material(folder, number("TransparencyFactor", "0.5"), " ", "TransparentColor");
  EXPECT_EQ(mask.materials[0].alpha.file, folder / "p.png");
  EXPECT_EQ(mask.materials[0].opacity, 1) << "a picture stands in the number's place";
  const Scan own = scan_of_fbx_material(folder, "", " ", "DiffuseColor", 4);
  EXPECT_EQ(own.materials[0].alpha.file, folder / "p.png")
      << "the diffuse picture's own alpha is the cut-out";
}

TEST(FaultsFbx, DefaultsOfTheFilesTemplate) {
  const TemporaryFolder folder;
  const std::string definitions =
      "Definitions: {\nObjectType: \"Material\" {\nPropertyTemplate: \"FbxSurfacePhong\" {\nProperties70: {\n"
      "P: \"DiffuseColor\", \"Color\", \"\", \"A\",0.25,0.5,1\n}\n}\n}\n}\nObjects:  {";
  const Scan scan = scan_of_fbx(folder, replaced(ascii_quad_fbx(), {{"Objects:  {", definitions}}));
  EXPECT_FLOAT_EQ(scan.materials[0].diffuse_factor.y, .5f);
}

TEST(FaultsFbx, PicturesAreMovedTurnedAndClamped) {
  const TemporaryFolder folder;
  const std::string v = "\", \"Vector\", \"\", \"A\",";
  const Scan moved =
      scan_of_fbx_material(folder, "", "P: \"Scaling" + v + "2,3,1\nP: \"Translation" + v + "0.25,0.5,0\n");
  EXPECT_FLOAT_EQ(moved.uvs[0].x, -.5f);  // 2 (0 - .25)
  EXPECT_FLOAT_EQ(moved.uvs[0].y, -1.5f);
  EXPECT_FLOAT_EQ(moved.uvs[2].x, 1.5f);
  const Scan turned = scan_of_fbx_material(folder, "", "P: \"Rotation" + v + "0,0,90\n");
  EXPECT_NEAR(turned.uvs[1].x, 0, 1e-6);  // (1, 0) turned by 90 degrees
  EXPECT_NEAR(turned.uvs[1].y, 1, 1e-6);
  const Scan clamped = scan_of_fbx_material(
      folder, "", "P: \"Scaling" + v + "2,2,1\nP: \"WrapModeU\", \"enum\", \"\", \"\",1\n");
  EXPECT_EQ(clamped.materials[0].diffuse.view.wrap_u, Wrap::kClamp);
  EXPECT_EQ(clamped.materials[0].diffuse.view.wrap_v, Wrap::kRepeat);
}

TEST(FaultsFbx, ColoursAtTheVertices) {
  const TemporaryFolder folder;
  const std::string layer =
      "LayerElementColor: 0 {\nMappingInformationType: \"ByPolygonVertex\"\n"
      "ReferenceInformationType: \"IndexToDirect\"\nColors: *8 {\na: 1,0,0,1,0,0.5,0,1\n}\n"
      "ColorIndex: *4 {\na: 0,1,1,0\n}\n}\nLayerElementUV: 0 {";
  const std::string file = replaced(ascii_quad_fbx(), {{"LayerElementUV: 0 {", layer}});
  const Scan scan = scan_of_fbx(folder, file);
  ASSERT_EQ(scan.corner_colours.size(), 4u);
  EXPECT_FLOAT_EQ(scan.corner_colours[1].rgb.y, srgb_to_linear(.5f));
  EXPECT_FLOAT_EQ(scan.corner_colours[3].rgb.x, 1);
  // A mirrored node turns its faces round, and their colours with them.
  const Scan mirrored = scan_of_fbx(folder, replaced(file, {{"\"A\",2,2,2", "\"A\",-2,2,2"}}));
  EXPECT_EQ(mirrored.corners[1].position, 3u);
  EXPECT_FLOAT_EQ(mirrored.corner_colours[1].rgb.x, 1);
  EXPECT_FLOAT_EQ(mirrored.corner_colours[3].rgb.y, srgb_to_linear(.5f));
  const Scan black = scan_of_fbx(folder, replaced(file, {{"1,0,0,1,0,0.5,0,1", "0,0,0,1,0,0,0,1"}}));
  EXPECT_TRUE(black.corner_colours.empty());
  EXPECT_TRUE(is_noted(black, "all black"));
  const Scan white = scan_of_fbx(folder, replaced(file, {{"1,0,0,1,0,0.5,0,1", "1,1,1,1,1,1,1,1"}}));
  EXPECT_TRUE(white.corner_colours.empty());
  EXPECT_FALSE(is_noted(white, "colours"));
  const Scan same =
      scan_of_fbx(folder, replaced(file, {{"ByPolygonVertex", "AllSame"}, {"a: 0,1,1,0", "a: 1"}}));
  EXPECT_FLOAT_EQ(same.corner_colours.at(3).rgb.y, srgb_to_linear(.5f));
}

std::string fbx_with_shape(const std::string& channel) {
  const std::string shape =
      "Geometry: 11, \"Geometry::smile\", \"Shape\" {\nIndexes: *2 {\na: 1,2\n}\n"
      "Vertices: *6 {\na: 0,0,1,0,0,1\n}\n}\n"
      "Deformer: 12, \"Deformer::shapes\", \"BlendShape\" {\n}\n"
      "Deformer: 13, \"SubDeformer::smile\", \"BlendShapeChannel\" {\n" +
      channel + "}\nModel: 20";
  return replaced(ascii_quad_fbx(), {{"Model: 20", shape},
                                     {"C: \"OO\",10,20",
                                      "C: \"OO\",10,20\nC: \"OO\",11,13\nC: \"OO\",13,12\nC: \"OO\",12,10"}});
}

TEST(FaultsFbx, ShapeKeysAtTheirWeights) {
  for (const auto& [channel, z] : std::vector<std::pair<std::string, float>>{
           {"DeformPercent: 50\n", .5f},
           {"DeformPercent: 0\n", 0},
           {"DeformPercent: 150\n", 1},
           {"DeformPercent: -50\n", 0},
           {"", 1},
           {"Properties70: {\nP: \"DeformPercent\", \"Number\", \"\", \"A\",25\n}\n", .25f},
           {"DeformPercent: 50\nFullWeights: *2 {\na: 50,50\n}\n", .25f}}) {
    const TemporaryFolder folder;
    const Scan scan = scan_of_fbx(folder, fbx_with_shape(channel));
    EXPECT_FLOAT_EQ(scan.positions[1].z, 2 * z) << channel << "the node scales by 2";
    EXPECT_FLOAT_EQ(scan.positions[0].z, 0) << channel;
    EXPECT_EQ(is_noted(scan, "'smile' at"), z > 0) << channel;
    EXPECT_FALSE(is_noted(scan, "rigged")) << channel;
  }
  const TemporaryFolder folder;
  const std::string damaged = replaced(fbx_with_shape("DeformPercent: 50\n"), {{"a: 1,2\n", "a: 1,9\n"}});
  expect_message(input_error_of([&] { scan_of_fbx(folder, damaged); }),
                 {"shape key 'smile'", "names a vertex"});
}

void expect_same_scan(const Scan& a, const Scan& b) {
  ASSERT_EQ(a.positions.size(), b.positions.size());
  for (size_t i = 0; i < a.positions.size(); ++i)
    for (int k = 0; k < 3; ++k) EXPECT_EQ(a.positions[i][k], b.positions[i][k]) << i;
  ASSERT_EQ(a.corners.size(), b.corners.size());
  for (size_t c = 0; c < a.corners.size(); ++c) {
    EXPECT_EQ(a.corners[c].position, b.corners[c].position) << c;
    EXPECT_EQ(a.uvs[a.corners[c].uv].x, b.uvs[b.corners[c].uv].x) << c;
  }
  EXPECT_EQ(a.groups, b.groups);
  EXPECT_EQ(a.stated_unit_cm, b.stated_unit_cm);
  ASSERT_EQ(a.materials.size(), b.materials.size());
  for (size_t m = 0; m < a.materials.size(); ++m) EXPECT_EQ(a.materials[m].name, b.materials[m].name);
}

TEST(FaultsFbx, AsciiVersion6IsTheSameAsVersion7) {
  const TemporaryFolder folder;
  const Scan seven = scan_of_fbx(folder, ascii_quad_fbx());
  const Scan six = scan_of_fbx(folder, ascii_quad_fbx6());
  expect_same_scan(six, seven);
  EXPECT_FLOAT_EQ(six.materials[0].diffuse_factor.y, .5f);
  EXPECT_TRUE(is_noted(six, "is FBX 6100"));
  expect_same_scan(scan_of_fbx(folder, replaced(ascii_quad_fbx6(), {{"\tFBXVersion: 6100\n", ""}})), seven);
  const Scan smiling =
      scan_of_fbx(folder, ascii_quad_fbx6("\t\t\tProperty: \"smile\", \"Shape\", \"A+N\",50\n"));
  EXPECT_FLOAT_EQ(smiling.positions[1].z, 1);
}

TEST(FaultsFbx, PicturesOfVersion6BelongToMeshes) {
  const TemporaryFolder folder;
  write_small_png(folder / "p.png");
  const std::string texture =
      "\tTexture: \"Texture::t\", \"TextureVideoClip\" {\n\t\tFileName: \"C:\\x\\p.png\"\n\t}\n";
  for (const std::string to :
       {"\"OO\", \"Texture::t\", \"Model::body\"", "\"OO\", \"Texture::t\", \"Material::cloth\"",
        "\"OP\", \"Texture::t\", \"Material::cloth\", \"DiffuseColor\""}) {
    const Scan scan = scan_of_fbx(folder, ascii_quad_fbx6("", texture, "\tConnect: " + to + "\n"));
    ASSERT_EQ(scan.materials.size(), 1u) << to;
    EXPECT_EQ(scan.materials[0].name, "cloth") << to;
    EXPECT_EQ(scan.materials[0].diffuse.file, folder / "p.png") << to;
  }
}

TEST(FaultsFbx, BinaryVersion6IsTheSameAsVersion7) {
  using W = FbxWriter;
  const auto list = [](const std::vector<double>& values, char type) {
    std::vector<std::string> items;
    for (double v : values)
      items.push_back(type == 'D' ? W::number(v) : "I" + W::raw(static_cast<int32_t>(v)));
    return items;
  };
  // 30 more vertices that no face uses: lists of more values than are kept one by one.
  std::vector<double> vertices{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  for (int i = 0; i < 90; ++i) vertices.push_back(i);
  W w;
  w.begin("Objects");
  w.begin("Model", {W::text(std::string("body\0\1Model", 11)), W::text("Mesh")});
  w.leaf("Vertices", list(vertices, 'D'));
  w.leaf("PolygonVertexIndex", list({0, 1, 2, -4}, 'I'));
  w.begin("LayerElementUV", {"I" + W::raw(int32_t{0})});
  w.leaf("UV", list({0, 0, 1, 0, 1, 1, 0, 1}, 'D'));
  w.end();
  w.end();
  w.end();
  w.begin("Connections");
  w.leaf("Connect", {W::text("OO"), W::text(std::string("body\0\1Model", 11)),
                     W::text(std::string("Scene\0\1Model", 12))});
  w.end();
  std::string bytes = w.finish();
  bytes.replace(23, 4, W::raw(uint32_t{6100}));
  const TemporaryFolder folder;
  const Scan scan = scan_of_fbx(folder, bytes);
  ASSERT_EQ(scan.positions.size(), 34u);
  EXPECT_EQ(scan.positions[33].z, 89);
  EXPECT_EQ(scan.corners[3].position, 3u);
  EXPECT_EQ(scan.uvs[scan.corners[2].uv].y, 1);
  EXPECT_EQ(scan.groups[0], "body");
}

TEST(FaultsFbx, PicturesInAsciiFilesAreBase64) {
  const TemporaryFolder folder;
  write_small_png(folder / "source.png", 3, 64);
  const std::string png = read_file(folder / "source.png");
  std::string base64(png.size() * 2, '\0'), content;
  base64.resize(static_cast<size_t>(EVP_EncodeBlock(reinterpret_cast<unsigned char*>(base64.data()),
                                                    reinterpret_cast<const unsigned char*>(png.data()),
                                                    static_cast<int>(png.size()))));
  for (const size_t piece : {base64.size(), size_t{40}}) {  // in one piece and in very many
    content = "Content: ,\n";
    for (size_t at = 0; at < base64.size(); at += piece)
      content += (at ? ",\n\"" : "\"") + base64.substr(at, piece) + "\"";
    const std::string objects =
        "Texture: 40, \"Texture::t\", \"\" {\n}\nVideo: 50, \"Video::v\", \"Clip\" {\n" + content +
        "\n}\n} ;end";
    const Scan scan =
        scan_of_fbx(folder, replaced(ascii_quad_fbx(), {{"} ;end", objects},
                                                        {"C: \"OO\",30,20",
                                                         "C: \"OO\",30,20\nC: \"OP\",40,30, "
                                                         "\"DiffuseColor\"\nC: \"OO\",50,40"}}));
    ASSERT_TRUE(scan.materials[0].diffuse.embedded) << piece;
    EXPECT_EQ(*scan.materials[0].diffuse.embedded, png) << piece;
  }
}

TEST(FaultsFbx, OtherVersionsAreNamed) {
  const TemporaryFolder folder;
  const std::string old = replaced(ascii_quad_fbx6(), {{"FBXVersion: 6100", "FBXVersion: 5800"}});
  expect_message(input_error_of([&] { scan_of_fbx(folder, old); }),
                 {"scan.fbx", "is FBX version 5800", "versions 6 and 7 are read"});
  std::string big_endian = quad_fbx();
  big_endian[22] = 1;
  expect_message(input_error_of([&] { scan_of_fbx(folder, big_endian); }), {"is big-endian FBX"});
}

TEST(FaultsFbx, ConnectionsOfPropertiesAreLeftOut) {
  const TemporaryFolder folder;
  const Scan scan = scan_of_fbx(
      folder, replaced(ascii_quad_fbx(),
                       {{"C: \"OO\",10,20", "C: \"PP\",30,\"Ambient\",20,\"Show\"\nC: \"OO\",10,20"}}));
  EXPECT_EQ(scan.materials.at(0).name, "cloth");
}

}  // namespace
}  // namespace ohb
