// Malformed scans and pictures: each is refused in one line that says where and what, or accepted on purpose.
#include <functional>

#include "dataset/commands/inspect.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/scan.h"
#include "tests/support/fbx_files.h"
#include "tests/support/picture_files.h"
#include "tests/support/scan_files.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace commands;
namespace {

constexpr const char* kAccepted = "";

struct Case {
  const char* name;
  std::function<std::filesystem::path(const TemporaryFolder&)> write;
  std::string message;  // a part of it; kAccepted: the scan loads and is inspected
};

void check(const std::vector<Case>& cases) {
  for (const Case& hostile : cases) {
    SCOPED_TRACE(hostile.name);
    const TemporaryFolder folder;
    const std::filesystem::path file = hostile.write(folder);
    if (hostile.message == kAccepted) {
      EXPECT_NO_THROW(inspect_text(inspect_scan(read_scan(file), "cm")));
    } else {
      expect_message(input_error_of([&] { inspect_scan(read_scan(file), "cm"); }),
                     {folder.path().string(), hostile.message});
    }
  }
}

Case file_case(const char* name, const std::string& file, const std::string& bytes,
               const std::string& message) {
  return {name, [=](const TemporaryFolder& folder) { return write_bytes(folder / file, bytes); }, message};
}

Case obj_case(const char* name, const std::string& text, const std::string& message) {
  return file_case(name, "scan.obj", text, message);
}

const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

TEST(HostileScans, Files) {
  check({
      {"nonexistent path", [](const TemporaryFolder& f) { return f / "none.obj"; }, "no such file"},
      {"folder instead of a file",
       [](const TemporaryFolder& f) {
         std::filesystem::create_directories(f / "scan.obj");
         return f / "scan.obj";
       },
       "is a folder"},
      {"dangling link",
       [](const TemporaryFolder& f) {
         std::filesystem::create_symlink(f / "gone.obj", f / "scan.obj");
         return f / "scan.obj";
       },
       "no such file"},
      file_case("unknown ending", "scan.ply", "ply\n", "unknown format '.ply'"),
      file_case("no ending", "scan", "x", "unknown format"),
      file_case("0-byte OBJ", "scan.obj", "", "0 bytes"),
      file_case("0-byte GLB", "scan.glb", "", "0 bytes"),
      file_case("0-byte FBX", "scan.fbx", "", "0 bytes"),
  });
}

TEST(HostileScans, ObjNumbers) {
  check({
      obj_case("NaN vertex", "v 0 0 0\nv 1 nan 2\nv 0 1 0\nf 1 2 3\n", "line 2: vertex 2 is not finite"),
      obj_case("infinite vertex", "v 0 0 0\nv inf 0 2\nv 0 1 0\nf 1 2 3\n", "line 2: vertex 2 is not finite"),
      obj_case("number too large", "v 0 0 0\nv 1e99 0 2\nv 0 1 0\nf 1 2 3\n",
               "line 2: vertex: '1e99' is no number"),
      obj_case("vertex with two numbers", "v 0 0 0\nv 1 2\nv 0 1 0\nf 1 2 3\n",
               "line 2: vertex has 2 numbers"),
      obj_case("vertex with letters", "v 0 0 0\nv 1 two 3\nv 0 1 0\nf 1 2 3\n", "'two' is no number"),
      obj_case("decimal commas", "v 0,5 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
               "line 1: vertex: '0,5' is no number"),
      obj_case("empty vertex", "v\nf 1 1 1\n", "line 1: vertex has 0 numbers"),
      obj_case("NaN UV", kTriangle + "vt 0 nan\nf 1/1 2/1 3/1\n", "line 4: UV 1 is not finite"),
      obj_case("hexadecimal", "v 0x10 0 0\nf 1 1 1\n", "'0x10' is no number"),
  });
}

TEST(HostileScans, ObjFaces) {
  check({
      obj_case("index out of range", kTriangle + "f 1 2 99999999\n",
               "line 4: face: vertex index 99999999 is out"),
      obj_case("index beyond 64 bits", kTriangle + "f 1 2 99999999999999999999\n", "is no vertex index"),
      obj_case("index zero", kTriangle + "f 0 1 2\n", "line 4: face: vertex index 0 is out of range"),
      obj_case("negative index too far", kTriangle + "f -1 -2 -4\n", "vertex index -4 is out of range"),
      obj_case("negative indices", kTriangle + "f -3 -2 -1\n", kAccepted),
      obj_case("UV out of range", kTriangle + "vt 0 0\nf 1/1 2/2 3/1\n",
               "line 5: face: UV index 2 is out of range"),
      obj_case("UV at some corners", kTriangle + "vt 0 0\nf 1/1 2 3/1\n", "UV at some corners only"),
      obj_case("two corners", kTriangle + "f 1 2\n", "line 4: face with 2 corners"),
      obj_case("no corners", kTriangle + "f\n", "line 4: face with 0 corners"),
      obj_case("words for corners", kTriangle + "f a b c\n", "'a' is no vertex index"),
      obj_case("broken corner", kTriangle + "f 1//x 2/y/ 3\n", "'y' is no UV index"),
      obj_case("no faces", kTriangle, "has no faces"),
      obj_case("no vertices", "f 1 2 3\n", "vertex index 1 is out of range: the file has 0"),
      obj_case("only text", "hello world\n", "has no faces"),
      obj_case("repeated vertex", kTriangle + "f 1 1 2\n", kAccepted),
      obj_case("all points equal", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n", kAccepted),
      obj_case("huge coordinates", "v -3e38 0 0\nv 3e38 0 0\nv 0 3e38 3e38\nf 1 2 3\n", kAccepted),
      obj_case("huge UVs", kTriangle + "vt -1e38 0\nvt 1e38 0\nvt 0 1e38\nf 1/1 2/2 3/3\n", kAccepted),
      obj_case("no UVs", kTriangle + "f 1 2 3\n", kAccepted),
      {"too many corners",
       [](const TemporaryFolder& folder) {
         std::string face = "f";
         for (int i = 0; i < 3000; ++i) face += " " + std::to_string(i % 3 + 1);
         return write_bytes(folder / "scan.obj", kTriangle + face + "\n");
       },
       "face with 3000 corners"},
      {"polygon without ears",
       [](const TemporaryFolder& folder) {
         std::string face = "f";
         for (int i = 0; i < 2000; ++i) face += " " + std::to_string(i % 3 + 1);
         return write_bytes(folder / "scan.obj", kTriangle + face + "\n");
       },
       kAccepted},
  });
}

TEST(HostileScans, ObjText) {
  check({
      obj_case("binary data", std::string("v 0 0 0\n\0\1\2", 11), "byte 8: is binary data"),
      obj_case("UTF-16", std::string("\xFF\xFEv\0 \0", 6), "UTF-16"),
      obj_case("very long line", kTriangle + "# " + std::string(5000000, 'x') + "\nf 1 2 3\n", kAccepted),
      obj_case("very long word", kTriangle + "f " + std::string(1000000, '1') + "\n", "is no vertex index"),
      obj_case("no end of line", kTriangle + "f 1 2 3", kAccepted),
      obj_case("continues at the end", kTriangle + "f 1 2 3 \\", kAccepted),
      obj_case("a million empty lines", std::string(1000000, '\n') + kTriangle + "f 1 2 3\n", kAccepted),
      {"70000 groups",
       [](const TemporaryFolder& folder) {
         std::string text = kTriangle;
         for (int i = 0; i < 70000; ++i) text += "g n" + std::to_string(i) + "\nf 1 2 3\n";
         return write_bytes(folder / "scan.obj", text);
       },
       "more than 65535 groups"},
  });
}

/// scan.obj with one material whose .mtl has `statements` below newmtl.
Case mtl_case(const char* name, const std::string& statements, const std::string& message,
              const std::string& picture_name = "", const std::string& picture = "") {
  return {name,
          [=](const TemporaryFolder& folder) {
            if (!picture_name.empty()) write_bytes(folder / picture_name, picture);
            write_bytes(folder / "m.mtl", "newmtl a\n" + statements);
            return write_bytes(folder / "scan.obj", "mtllib m.mtl\nusemtl a\n" + std::string(kQuadObj));
          },
          message};
}

TEST(HostileScans, Materials) {
  check({
      obj_case("missing .mtl", "mtllib none.mtl\n" + kTriangle + "f 1 2 3\n",
               "line 1: material library 'none.mtl' is not"),
      obj_case("mtllib without name", "mtllib\n" + kTriangle + "f 1 2 3\n", "mtllib without a file name"),
      obj_case("material without library", "usemtl x\n" + kTriangle + "f 1 2 3\n", kAccepted),
      {"material that no library has",
       [](const TemporaryFolder& folder) {
         write_bytes(folder / "m.mtl", "newmtl a\n");
         return write_bytes(folder / "scan.obj", "mtllib m.mtl\nusemtl b\n" + kTriangle + "f 1 2 3\n");
       },
       "usemtl b"},
      mtl_case("missing picture", "map_Kd none.png\n", "line 2: picture 'none.png' is not there"),
      mtl_case("picture without name", "map_Kd\n", "line 2: map_Kd without a picture"),
      mtl_case("option without value", "map_Kd -bm\n", "option -bm without its value"),
      mtl_case("offset that is none", "map_Kd -o nan 0 p.png\n", "option -o without its value"),
      mtl_case("alpha from the red channel", "map_d -imfchan r p.png\n", "takes the channel 'r'"),
      mtl_case("colour that is none", "Kd red\n", "Kd: 'red' is no colour"),
      mtl_case("negative colour", "Kd -1 0 0\n", "Kd: '-1' is no colour"),
      mtl_case("material twice", "newmtl a\n", "material 'a' is there twice"),
      mtl_case("0-byte PNG", "map_Kd p.png\n", "p.png: is empty (0 bytes)", "p.png", ""),
      mtl_case("text as PNG", "map_Kd p.png\n", "is no PNG, JPEG, TIFF, EXR or HDR", "p.png",
               "not a picture"),
      mtl_case("PNG signature only", "map_Kd p.png\n", "p.png: ", "p.png", "\x89PNG\r\n\x1a\n"),
      mtl_case("JPEG start only", "map_Kd p.jpg\n", "p.jpg: ", "p.jpg", "\xff\xd8\xff\xe0"),
      mtl_case("EXR magic only", "map_Kd p.exr\n", "p.exr: ", "p.exr", "\x76\x2f\x31\x01\x02"),
      mtl_case("TIFF magic only", "map_Kd p.tif\n", "p.tif: ", "p.tif",
               std::string("II*\0\xff\xff\xff\xff", 8)),
      mtl_case("HDR magic only", "map_Kd p.hdr\n", "p.hdr: ", "p.hdr", "#?RADIANCE\n"),
      {"picture is a folder",
       [](const TemporaryFolder& folder) {
         std::filesystem::create_directories(folder / "p.png");
         write_bytes(folder / "m.mtl", "newmtl a\nmap_Kd p.png\n");
         return write_bytes(folder / "scan.obj", "mtllib m.mtl\nusemtl a\n" + std::string(kQuadObj));
       },
       "picture 'p.png' is not there"},
  });
}

TEST(HostileScans, TruncatedPictures) {
  // Where an image ends early it is refused, wherever that is.
  for (const std::string name : {"p.png", "p.exr"}) {
    const std::string whole = picture_bytes(name);
    for (const double share : {0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99}) {
      const std::string part =
          whole.substr(0, static_cast<size_t>(share * static_cast<double>(whole.size())));
      check({mtl_case((name + " cut to " + std::to_string(share)).c_str(), "map_Kd " + name + "\n",
                      name + ": ", name, part)});
    }
    check({mtl_case(name.c_str(), "map_Kd " + name + "\n", kAccepted, name, whole)});
  }
  std::string damaged = picture_bytes("p.png");
  damaged[damaged.size() / 2] ^= 0x10;
  check({mtl_case("damaged PNG", "map_Kd p.png\n", "wrong checksum", "p.png", damaged)});
  std::string claims = picture_bytes("p.png");
  claims.replace(16, 8, std::string("\0\0\xff\xff\0\0\xff\xff", 8));  // 65535 x 65535
  check({mtl_case("PNG that claims 12 GB", "map_Kd p.png\n", "p.png: ", "p.png", claims)});
}

TEST(HostileScans, JpegWithoutItsEnd) {
  const std::string whole = small_jpeg();
  check({mtl_case("whole JPEG", "map_Kd p.jpg\n", kAccepted, "p.jpg", whole),
         mtl_case("JPEG without end marker", "map_Kd p.jpg\n", "truncated", "p.jpg",
                  whole.substr(0, whole.size() - 2)),
         mtl_case("JPEG cut in its tables", "map_Kd p.jpg\n", "p.jpg: ", "p.jpg", whole.substr(0, 60))});
}

/// The square's GLB with the first `from` in its JSON replaced.
Case glb_case(const char* name, const std::string& from, const std::string& to, const std::string& message) {
  std::string json = quad_glb_json();
  const size_t at = json.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  json.replace(at, from.size(), to);
  return file_case(name, "scan.glb", glb_of(json, quad_glb_binary()), message);
}

TEST(HostileScans, Glb) {
  std::string other_version = glb_of(quad_glb_json(), quad_glb_binary());
  other_version[4] = 1;
  std::string nested = R"({"extras":)" + std::string(200000, '[') + std::string(200000, ']') + "}";
  std::string nan_binary = quad_glb_binary();
  nan_binary.replace(0, 4, "\xff\xff\xff\x7f");
  std::string far_index = quad_glb_binary();
  far_index.replace(80, 2, "\xff\xff");
  check({
      file_case("whole GLB", "scan.glb", glb_of(quad_glb_json(), quad_glb_binary()), kAccepted),
      file_case("wrong magic", "scan.glb", "gltf" + std::string(100, 'x'), "does not begin with 'glTF'"),
      file_case("version 1", "scan.glb", other_version, "glTF version 1"),
      file_case("JSON garbage", "scan.glb", glb_of("{\"asset\":[}", ""), "is not well-formed JSON"),
      file_case("JSON is a number", "scan.glb", glb_of("42", ""), "is no object"),
      file_case("deeply nested JSON", "scan.glb", glb_of(nested, ""), "deeper than 128 levels"),
      file_case("no binary chunk", "scan.glb", glb_of(quad_glb_json(), ""), "the binary chunk is missing"),
      file_case("short binary chunk", "scan.glb", glb_of(quad_glb_json(), "abcd"),
                "buffers[0]: states 92 bytes"),
      file_case("NaN position", "scan.glb", glb_of(quad_glb_json(), nan_binary), "vertex 1 is not finite"),
      file_case("index out of range", "scan.glb", glb_of(quad_glb_json(), far_index), "index 0 is 65535"),
      file_case("gltf without buffer file", "scan.gltf", R"({"buffers":[{"uri":"none.bin","byteLength":4}]})",
                "none.bin"),
      file_case("bad base64", "scan.gltf", R"({"buffers":[{"uri":"data:x;base64,@@@@","byteLength":4}]})",
                "not base64"),
      glb_case("accessor out of range", R"("POSITION":0)", R"("POSITION":7)", "accessors[7]: is used but"),
      glb_case("accessor beyond its view", R"("count":4)", R"("count":5)", "goes beyond its buffer view"),
      glb_case("huge count", R"("count":4)", R"("count":4000000000)", "has 4000000000 elements"),
      glb_case("absurd count", R"("count":4)", R"("count":1e300)", "is no index"),
      glb_case("negative offset", R"("byteOffset":48)", R"("byteOffset":-48)", "is no index"),
      glb_case("overflowing offset", R"("byteOffset":48)", R"("byteOffset":9007199254740992)",
               "goes beyond its buffer"),
      glb_case("wrong type", R"("VEC3")", R"("MAT4")", "has the type 'MAT4'"),
      glb_case("unknown component type", "5126", "999", "unknown component type 999"),
      glb_case("mesh out of range", R"("mesh":0)", R"("mesh":3)", "meshes[3]"),
      glb_case("node is its own child", R"("mesh":0)", R"("mesh":0,"children":[0])", "its own ancestor"),
      glb_case("child is a text", R"("mesh":0)", R"("mesh":0,"children":["x"])", "JSON: type must be number"),
      glb_case("scene out of range", R"("scene":0)", R"("scene":9)", "scenes[9]"),
      glb_case("copies", R"("scene":0)", R"("extensionsRequired":["EXT_mesh_gpu_instancing"])",
               "needs EXT_mesh_gpu_instancing"),
      glb_case("lines only", R"("indices":2)", R"("indices":2,"mode":1)", "has no faces"),
      glb_case("UVs of another length", R"("count":4,"type":"VEC2")", R"("count":3,"type":"VEC2")",
               "3 UVs for 4"),
      glb_case("matrix of nulls", R"("mesh":0)", R"("mesh":0,"matrix":[null])", "JSON: "),
      glb_case("scale overflow", R"("mesh":0)", R"("mesh":0,"scale":[1e300,1,1])", "is not finite"),
  });
}

TEST(HostileScans, TruncatedGlb) {
  const TemporaryFolder pictures;
  write_small_png(pictures / "p.png", 4);
  const std::string png = read_file(pictures / "p.png");
  const std::string whole = glb_of(quad_glb_json(png.size()), quad_glb_binary(png));
  check({file_case("whole", "scan.glb", whole, kAccepted)});
  for (size_t length : {4, 11, 12, 19, 20, 100, 500})
    check({file_case("cut GLB", "scan.glb", whole.substr(0, length), "scan.glb: ")});
  check({file_case("cut by a byte", "scan.glb", whole.substr(0, whole.size() - 1), "truncated")});
  const std::string cut_png = png.substr(0, png.size() / 2);
  check({file_case("embedded PNG cut", "scan.glb",
                   glb_of(quad_glb_json(cut_png.size()), quad_glb_binary(cut_png)),
                   "scan.glb#image0: is truncated")});
}

TEST(HostileScans, Fbx) {
  const std::string binary = quad_fbx();
  std::string old_version = binary, damaged = binary, nested = ascii_quad_fbx();
  old_version.replace(23, 4, std::string("\0\x10\0\0", 4));
  nested += "\n";
  for (int i = 0; i < 100; ++i) nested += "A: {\n";
  damaged.replace(27, 4, "\xff\xff\xff\x7f");
  const auto ascii_with = [](const std::string& from, const std::string& to) {
    std::string text = ascii_quad_fbx();
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  };
  check({
      file_case("whole", "scan.fbx", binary, kAccepted),
      file_case("ASCII", "scan.fbx", ascii_quad_fbx(), kAccepted),
      file_case("garbage", "scan.fbx", std::string(1000, '\x5a'), "is no FBX file"),
      file_case("magic only", "scan.fbx", binary.substr(0, 23), "header is cut off"),
      file_case("other version", "scan.fbx", old_version, "is FBX version 4096"),
      file_case("node beyond the file", "scan.fbx", damaged, "ends outside its parent"),
      file_case("no Objects", "scan.fbx", binary.substr(0, 27) + std::string(13, '\0'),
                "Objects: are missing"),
      file_case("nested too deeply", "scan.fbx", nested, "nested too deeply"),
      file_case("index out of range", "scan.fbx", ascii_with("0,1,2,-4", "0,1,9,-4"),
                "corner 3 names vertex 10 of 4"),
      file_case("no end of polygon", "scan.fbx", ascii_with("0,1,2,-4", "0,1,2,3"), "ends within a polygon"),
      file_case("face of two corners", "scan.fbx", ascii_with("0,1,2,-4", "0,-2,2,-4"),
                "face 1: has 2 corners"),
      file_case("NaN vertex", "scan.fbx", ascii_with("0,0,0,1", "0,nan,0,1"), "vertex 1 is not finite"),
      file_case("text as number", "scan.fbx", ascii_with("0,0,0,1", "0,abc,0,1"), "'abc' is no number"),
      file_case("UV index out of range", "scan.fbx", ascii_with("a: 0,1,2,3", "a: 0,1,2,7"),
                "UV index out of range"),
      file_case("unit of zero", "scan.fbx", ascii_with("\"Number\", \"\",100", "\"Number\", \"\",0"),
                "UnitScaleFactor"),
      file_case("bracket missing", "scan.fbx", ascii_with("} ;end", ";end"), "line "),
  });
  const size_t footer_bytes = 13 + 176;  // nothing is lost with the footer
  for (double share = 0.05; share < 1; share += 0.05) {
    const auto length = static_cast<size_t>(share * static_cast<double>(binary.size() - footer_bytes));
    check({file_case("cut FBX", "scan.fbx", binary.substr(0, length), "scan.fbx: ")});
  }
}

}  // namespace
}  // namespace ohb
