// Pictures and .mtl files whose names come from other machines.
#include "tests/support/scan_files.h"
#include <nlohmann/json.hpp>

#include "dataset/commands/inspect.h"
#include "dataset/model/scan.h"
#include "tests/support/fbx_files.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace commands;
namespace {

namespace fs = std::filesystem;

/// A square whose .mtl names `written`.
fs::path obj_naming(const TemporaryFolder& folder, const std::string& written) {
  write_bytes(folder / "m.mtl", "newmtl a\nmap_Kd " + written + "\n");
  return write_bytes(folder / "scan.obj", "mtllib m.mtl\nusemtl a\n" + std::string(kQuadObj));
}

/// A PNG at `file`, folders on the way made.
void put_png(const fs::path& file) {
  fs::create_directories(file.parent_path());
  write_small_png(file);
}

bool holds(const std::vector<std::string>& lines, const std::string& part) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(part) != std::string::npos; });
}

struct Name {
  const char* what;
  std::string written, there;
};

const std::vector<Name> kNames{
    {"Windows path", "C:\\Users\\someone\\Desktop\\scan\\tex.png", "tex.png"},
    {"network path", "\\\\server\\share\\tex.png", "tex.png"},
    {"Unix path", "/home/someone/scan/tex.png", "tex.png"},
    {"file URL", "file:///home/someone/my%20tex.png", "my tex.png"},
    {"end of the path", "D:/scans/Textures/tex.png", "textures/tex.png"},
    {"above the scan", "../../elsewhere/tex.png", "tex.png"},
    {"quotes", "\"my tex.png\"", "my tex.png"},
    {"single quotes and blanks", "' my tex.png ' ", "my tex.png"},
    {"other case", "Tex.PNG", "tex.png"},
    {"other case on disk", "tex.png", "TEX.PNG"},
    {"usual folder", "tex.png", "textures/tex.png"},
    {"usual folder of other case", "skin.png", "Images/Skin.png"},
    {"folder of the scan's name", "tex.png", "scan_textures/tex.png"},
    {"Latin-1",
     "M\xe4"
     "dchen.png",
     "M\xc3\xa4"
     "dchen.png"},
    {"Latin-1 on disk",
     "M\xc3\xa4"
     "dchen.png",
     "M\xe4"
     "dchen.png"},
    {"GBK", "\xc6\xa4\xb7\xf4.png", "\xe7\x9a\xae\xe8\x82\xa4.png"},
    {"unpacked as CP437",
     "M\xc3\xa4"
     "dchen.png",
     "M\x84"
     "dchen.png"},
    {"read twice as Latin-1",
     "M\xc3\xa4"
     "dchen.png",
     "M\xc3\x83\xc2\xa4"
     "dchen.png"},
    {"decomposed",
     "Ma\xcc\x88"
     "dchen.png",
     "M\xc3\xa4"
     "dchen.png"},
    {"decomposed on disk",
     "M\xc3\xa4"
     "dchen.png",
     "Ma\xcc\x88"
     "dchen.png"},
    {"sharp s and case", "GROSSE.png",
     "gro\xc3\x9f"
     "e.png"},
    {"comment", "tex.png #skin", "tex.png"},
    {"escaped", "my%20tex.png", "my tex.png"},
    {"escaped folder", "Textures%5Ctex.png", "textures/tex.png"},
    {"escaped on disk", "my tex.png", "my%20tex.png"},
};

TEST(ScanNames, PicturesOfOtherMachinesAreFoundAndSaid) {
  for (const Name& name : kNames) {
    const TemporaryFolder folder;
    put_png(folder / name.there);
    put_png(folder / "other.png");
    const Scan scan = read_scan(obj_naming(folder, name.written));
    EXPECT_EQ(scan.materials.at(0).diffuse.file, folder / name.there) << name.what;
    EXPECT_TRUE(holds(scan.notes, "m.mtl: line 2: ")) << name.what;
  }
}

TEST(ScanNames, SameInFbx) {
  for (const Name& name : kNames) {
    if (name.written.find('"') != std::string::npos) continue;
    const TemporaryFolder folder;
    put_png(folder / name.there);
    std::string fbx = ascii_quad_fbx();
    fbx.replace(fbx.find("} ;end"), 6,
                "Texture: 40, \"Texture::t\", \"\" {\nFileName: \"" + name.written + "\"\n}\n}");
    fbx.replace(fbx.rfind("}"), 1, "C: \"OP\",40,30, \"DiffuseColor\"\n}");
    const Scan scan = read_scan(write_bytes(folder / "scan.fbx", fbx));
    EXPECT_EQ(scan.materials.at(0).diffuse.file, folder / name.there) << name.what;
    EXPECT_TRUE(holds(scan.notes, "texture 't'")) << name.what;
  }
}

TEST(ScanNames, SameInGltf) {
  for (const Name& name : kNames) {
    if (name.what == std::string("Latin-1") || name.what == std::string("GBK")) continue;  // JSON is UTF-8
    const TemporaryFolder folder;
    put_png(folder / name.there);
    nlohmann::json json = nlohmann::json::parse(quad_glb_json(1));
    json["images"][0] = {{"uri", name.written}};
    json["bufferViews"].erase(3);
    json["buffers"][0]["byteLength"] = 92;
    const Scan scan = read_scan(write_bytes(folder / "scan.glb", glb_of(json.dump(), quad_glb_binary())));
    EXPECT_EQ(scan.materials.at(0).diffuse.file, folder / name.there) << name.what;
  }
}

TEST(ScanNames, NamesAsWrittenGoFirstAndAreNotNoted) {
  const TemporaryFolder folder;
  put_png(folder / "textures/tex.png");
  put_png(folder / "tex.png");
  put_png(folder / "TEX.png");
  const Scan scan = read_scan(obj_naming(folder, "textures\\tex.png"));
  EXPECT_EQ(scan.materials.at(0).diffuse.file, folder / "textures/tex.png");
  EXPECT_TRUE(scan.notes.empty());
}

TEST(ScanNames, BesideTheFolderOfTheScan) {
  const TemporaryFolder folder;
  put_png(folder / "textures/tex.png");
  write_bytes(folder / "source/m.mtl", "newmtl a\nmap_Kd tex.png\n");
  const Scan scan =
      read_scan(write_bytes(folder / "source/scan.obj", "mtllib M.MTL\nusemtl a\n" + std::string(kQuadObj)));
  EXPECT_EQ(scan.materials.at(0).diffuse.file, folder / "textures/tex.png");
  EXPECT_TRUE(holds(scan.notes, "scan.obj: line 1: 'M.MTL'"));
}

TEST(ScanNames, TwoThatFitAreAskedAbout) {
  const TemporaryFolder folder;
  put_png(folder / "TEX.png");
  put_png(folder / "Tex.png");
  const fs::path file = obj_naming(folder, "tex.png");
  EXPECT_EQ(read_scan(file).materials.at(0).diffuse.file, folder / "TEX.png") << "copies are no question";
  write_small_png(folder / "Tex.png", 4);
  expect_message(input_error_of([&] { read_scan(file); }),
                 {"m.mtl: line 2: picture 'tex.png'", "both TEX.png and Tex.png", "remove the wrong one"});
}

TEST(ScanNames, NearestNameIsNamed) {
  const TemporaryFolder folder;
  put_png(folder / "skin_diffuse.png");
  put_png(folder / "hair.png");
  const fs::path file = obj_naming(folder, "C:\\x\\skin_difuse.png");
  expect_message(
      input_error_of([&] { read_scan(file); }),
      {"'C:\\x\\skin_difuse.png' is not there", "put it at " + (folder / "skin_difuse.png").string(),
       "nearest name there is 'skin_diffuse.png'"});
}

TEST(ScanNames, HashesInNamesAreNoComments) {
  const TemporaryFolder folder;
  put_png(folder / "Body #2.png");
  write_bytes(folder / "m.mtl",
              "# head\nnewmtl Material #1 # one\nKd 1 0 0 # red\nnewmtl Material #2\nmap_Kd Body #2.png\n");
  const Scan scan = read_scan(write_bytes(
      folder / "scan.obj",
      "mtllib m.mtl\nusemtl Material #2\n" + std::string(kQuadObj) + "usemtl Material #1\nf 1 2 3 # x\n"));
  ASSERT_EQ(scan.materials.size(), 2u);
  EXPECT_EQ(scan.materials[0].diffuse.file, folder / "Body #2.png");
  EXPECT_EQ(scan.materials[1].name, "Material #1");
  EXPECT_EQ(scan.materials[1].diffuse_factor.y, 0);
}

TEST(ScanNames, WhatIsMissingIsReportedByInspectAlone) {
  const TemporaryFolder folder;
  write_bytes(folder / "empty.png", "");
  write_bytes(folder / "m.mtl", "newmtl a\nmap_Kd none.png\nmap_d empty.png\n");
  write_bytes(folder / "scans.mtl", "newmtl c\n");
  const fs::path pictures = write_bytes(folder / "p.obj", "mtllib m.mtl\nusemtl a\n" + std::string(kQuadObj));
  const fs::path library =
      write_bytes(folder / "l.obj", "mtllib scan.mtl\nusemtl b\n" + std::string(kQuadObj));
  const fs::path name = write_bytes(folder / "n.obj", "mtllib m.mtl\nusemtl b\n" + std::string(kQuadObj));
  for (const auto& [file, count, what] :
       {std::tuple(pictures, 2u, "m.mtl: line 2: picture 'none.png' is not there"),
        {library, 1u, "l.obj: line 1: material library 'scan.mtl' is not there"},
        {name, 3u, "n.obj: usemtl b: no .mtl file of the scan has"}}) {
    const InspectReport report = inspect_scan(read_scan(file, MissingFiles::kReported), "cm");
    ASSERT_EQ(report.missing.size(), count) << file;
    const bool is_said =
        std::any_of(report.warnings.begin(), report.warnings.end(),
                    [what = what](const Warning& w) { return w.what.find(what) != std::string::npos; });
    EXPECT_TRUE(is_said) << what;
    expect_message(input_error_of([&, file = file] { read_scan(file); }), {"is not there"});
  }
  expect_message(input_error_of([&] { read_scan(library); }), {"'scans.mtl' is there: name it"});
  expect_message(input_error_of([&] { read_scan(pictures); }), {"so with 1 more, which inspect lists"});
}

}  // namespace
}  // namespace ohb
