#include "tests/fuzz/readers.h"

#include <sstream>

#include "dataset/commands/inspect.h"
#include "dataset/commands/label.h"
#include "dataset/commands/label_serve.h"
#include "dataset/environments/library.h"
#include "dataset/environments/panorama.h"
#include "dataset/exports/sample_index.h"
#include "dataset/labelling/strokes.h"
#include "dataset/model/environment.h"
#include "dataset/model/material_table.h"
#include "dataset/model/model.h"
#include "dataset/model/sample.h"
#include "dataset/model/sample_listing.h"
#include "dataset/model/scan_unit.h"
#include "dataset/studies/bake_stress.h"
#include "dataset/studies/stress.h"
#include "tests/support/fbx_files.h"
#include "tests/support/foreign_files.h"
#include "tests/support/paths.h"
#include "tests/support/picture_files.h"
#include "tests/support/scan_files.h"
#include "tests/support/test_models.h"

namespace ohb {
using namespace commands;
using namespace labelling;
using namespace studies;
namespace fs = std::filesystem;
namespace {

constexpr const char* kStrokes =
    "<strokes schema=\"1.0\">\n<stroke class=\"leather\" radius_cm=\"1.5\" time_s=\"2\">\n"
    "<point face=\"0\" at=\"0.5,0.5,0\"/>\n<point face=\"0\" at=\"0.6,0.5,0\"/>\n</stroke>\n</strokes>\n";
constexpr const char* kRules =
    "<rules schema=\"1.0\" default=\"fabric\">\n<rule class=\"skin\" words=\"body|running shoe\" "
    "except=\"*wear\"/>\n"
    "<rule class=\"hair\" name=\"a*|?b\" uv_polygon=\"0,0 1,0 1,1\" colour_space=\"lab\" colour_low=\"0 -9 "
    "-9\" "
    "colour_high=\"90 9 9\"/>\n</rules>\n";
constexpr const char* kMaterials =
    "<materials schema=\"1.0\" specular_encoding=\"srgb-f0\" roughness_encoding=\"perceptual\" "
    "sss_encoding=\"weight-1.0-0.2-0.1-cm\">\n<material class=\"skin\" specular=\".184\" roughness=\".4\" "
    "sss=\".08\"/>\n"
    "<material class=\"hair\" specular=\".239\" roughness=\".5\" sss=\"0\"/>\n"
    "<material class=\"fabric\" specular=\".263\" roughness=\".85\" sss=\"0\"/>\n"
    "<material class=\"leather\" specular=\".224\" roughness=\".25\" sss=\"0\"/>\n</materials>\n";
constexpr const char* kServeLines =
    "{\"id\":1,\"do\":\"stroke\",\"class\":\"skin\",\"radius_cm\":0.4,\"points\":[[0,0.5,0.5,0],[0,0.6,0.5,0]"
    "]}\n"
    "{\"id\":{\"a\":[1,2]},\"do\":\"stroke\",\"class\":\"hair\",\"radius_cm\":1e-3,\"points\":[[0,0.1,0.5,0]]"
    "}\n"
    "{\"id\":2,\"do\":\"undo\"}\n{\"id\":3,\"do\":\"save\",\"file\":\"\"}\n{\"do\":\"undo\",\"id\":[[[[]]]]}"
    "\n";

constexpr const char* kEnvironments =
    "<environments version=\"1\" radiance=\"linear\">\n<environment id=\"a-1_b\" category=\"imported\" "
    "licence=\"CC0-1.0\" source=\"\" origin=\"a.exr\" made_from=\"import 1\" sha256=\"00\" bytes=\"12\" "
    "width=\"64\" values=\"half\" mean_r=\".5\" mean_g=\".5\" mean_b=\".5\" peak=\"2e3\" brightest_x=\"0\" "
    "brightest_y=\"1\" brightest_z=\"0\" mended_nan=\"0\" mended_infinite=\"0\" mended_negative=\"0\"/>\n"
    "</environments>\n";
constexpr const char* kDataset =
    "<dataset schema=\"1\" name=\"d\">\n<people>\n<person id=\"ann\" split=\"train\" sex=\"female\" "
    "views=\"v\" sets=\"1\" planned_sets=\"1\"/>\n</people>\n</dataset>\n";
std::string obj_text() {
  return "mtllib m.mtl\ng body\nusemtl a\n" + std::string(kQuadObj) +
         "vn 0 0 1\nv 2 0 0 1 .5 .25\nv 2 1 0 1 1 1\nf -1/-1/1 -2/-2/1 -3/-3/1\nf 1/1 2/2 5/2 6/3 3/3\n";
}
constexpr const char* kMtl =
    "newmtl a\nKd 1 .5 .25\nd .8\nmap_Kd -s 1 1 1 p.png\nmap_d -imfchan m p.png\nbump -bm 1 n.png\nnewmtl "
    "b\nTr .1\n";

/// Whatever reads scans: the reader, what is made of it, and the report.
void read_and_inspect(const fs::path& file) {
  const Scan scan = read_scan(file);
  if (fs::file_size(file) % 8 == 0) inspect_text(inspect_scan(scan, "cm"));  // it takes most of the time
}

std::string picture_of(
    const fs::path& scratch, const std::string& name, OIIO::TypeDesc type, int channels = 3,
    const std::function<void(OIIO::ImageSpec&)>& change = [](OIIO::ImageSpec&) {}) {
  Image image(16, 8, channels);
  for (size_t i = 0; i < image.values.size(); ++i) image.values[i] = static_cast<float>(i % 97) / 97;
  return read_file(write_picture_with(scratch / name, image, type, change));
}

/// The same bytes as a picture and as an environment.
FuzzedReader picture_reader(const std::string& name, const std::string& file, const std::string& bytes) {
  return {name, {{file, bytes}}, 1, [file](const fs::path& folder) {
            const Image image = read_image(folder / file);
            if (image.values.size() != static_cast<size_t>(image.width_px) * image.height_px * image.channels)
              throw std::logic_error("an image of another size than it says");
            const ImageFileInfo info = probe_image(folder / file);
            if (info.width_px != image.width_px || info.height_px != image.height_px)
              throw std::logic_error("probe_image and read_image differ");
            try {
              read_image_bytes(read_file(folder / file), "embedded");
            } catch (const InputError&) {
            }
            try {
              environments::read_panorama(folder / file);
            } catch (const InputError&) {
            }
            read_environment(folder / file);
          }};
}

void add_pictures(const fs::path& scratch, std::vector<FuzzedReader>& readers) {
  const OIIO::TypeDesc bytes = OIIO::TypeDesc::UINT8, words = OIIO::TypeDesc::UINT16,
                       half = OIIO::TypeDesc::HALF;
  readers.push_back(picture_reader("Png", "p.png", picture_of(scratch, "a.png", bytes, 4)));
  readers.push_back(picture_reader("Png16", "p.png", picture_of(scratch, "b.png", words)));
  readers.push_back(picture_reader("Jpeg", "p.jpg", picture_of(scratch, "a.jpg", bytes)));
  readers.push_back(picture_reader("Tiff", "p.tif", picture_of(scratch, "a.tif", bytes, 4)));
  readers.push_back(picture_reader(
      "TiffTiled", "p.tif",
      picture_of(scratch, "b.tif", words, 3, [](auto& spec) { spec.tile_width = spec.tile_height = 16; })));
  readers.push_back(picture_reader("Exr", "p.exr", picture_of(scratch, "a.exr", half, 3, [](auto& spec) {
                                     spec.x = 2, spec.y = -1, spec.full_width = 32, spec.full_height = 16;
                                   })));
  readers.push_back(picture_reader("ExrTiled", "p.exr",
                                   picture_of(scratch, "b.exr", OIIO::TypeDesc::FLOAT, 1,
                                              [](auto& spec) { spec.tile_width = spec.tile_height = 16; })));
  readers.push_back(picture_reader("Hdr", "p.hdr", picture_of(scratch, "a.hdr", OIIO::TypeDesc::FLOAT)));
  readers.push_back(picture_reader(
      "HdrTurned", "p.hdr",
      radiance_picture("-X", "+Y", 16, 8, [](int x, int y) { return static_cast<uint8_t>(128 + x + y); })));
}

void add_scans(std::vector<FuzzedReader>& readers) {
  const std::string png = picture_bytes("p.png", 4);
  const std::vector<std::pair<std::string, std::string>> beside = {
      {"m.mtl", kMtl}, {"p.png", png}, {"n.png", png}};
  const auto inspect = [](const char* file) {
    return [file](const fs::path& folder) { read_and_inspect(folder / file); };
  };
  FuzzedReader obj{"Obj", {{"s.obj", obj_text()}}, 1, inspect("s.obj")}, mtl = obj;
  obj.files.insert(obj.files.end(), beside.begin(), beside.end());
  mtl.name = "Mtl";
  mtl.files = {beside[0], {"s.obj", obj_text()}, beside[1], beside[2]};
  readers.push_back(obj);
  readers.push_back(mtl);
  readers.push_back(
      {"Glb", {{"s.glb", glb_of(quad_glb_json(png.size()), quad_glb_binary(png))}}, 1, inspect("s.glb")});
  std::string gltf = quad_glb_json();
  gltf.replace(gltf.find(R"("buffers":[{)"), 12, R"("buffers":[{"uri":"s.bin",)");
  readers.push_back({"Gltf", {{"s.gltf", gltf}, {"s.bin", quad_glb_binary()}}, 2, inspect("s.gltf")});
  readers.push_back({"Fbx", {{"s.fbx", quad_fbx()}}, 1, inspect("s.fbx")});
  readers.push_back({"FbxText", {{"s.fbx", ascii_quad_fbx()}}, 1, inspect("s.fbx")});
}

void add_labels(std::vector<FuzzedReader>& readers) {
  const std::pair<std::string, std::string> obj{"s.obj", kQuadObj};
  readers.push_back({"Strokes", {{"x.xml", kStrokes}, obj}, 1, [](const fs::path& folder) {
                       read_strokes(folder / "x.xml", read_scan(folder / "s.obj"), 1);
                     }});
  readers.push_back({"Rules", {{"x.xml", kRules}, obj}, 1, [](const fs::path& folder) {
                       const LabelRules rules = read_label_rules(folder / "x.xml");
                       RuleOutcome outcome;
                       apply_rules(rules, read_scan(folder / "s.obj"), {{.5f, .5f, .5f}}, outcome);
                     }});
  readers.push_back({"Materials", {{"x.xml", kMaterials}}, 1, [](const fs::path& folder) {
                       read_material_table(folder / "x.xml");
                     }});
  readers.push_back({"FaceClasses", {{"x.txt", "0\n1\n2\n3\n255\n0\n"}}, 1, [](const fs::path& folder) {
                       read_face_classes(folder / "x.txt", 6, {"skin", "hair", "fabric", "leather"});
                     }});
  readers.push_back(
      {"ClassesBeside",
       {{"s.json", R"({"classes": ["skin", "hair"], "unit": {"cm": 1}})"}},
       1,
       [](const fs::path& folder) { class_order_of(folder / "s.labels.txt", folder / "s.obj"); }});
  readers.push_back({"Serve", {{"lines", kServeLines}, obj}, 1, [](const fs::path& folder) {
                       fs::current_path(folder);  // "save" writes where the line says
                       std::istringstream in(read_file(folder / "lines"));
                       std::ostringstream out;
                       serve_labels({folder / "s.obj", "", "m", "y"}, in, out);
                       fs::current_path(fs::temp_directory_path());
                     }});
}

/// All files below a folder, the small texts first.
std::vector<std::pair<std::string, std::string>> files_below(const fs::path& folder) {
  std::vector<std::pair<std::string, std::string>> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      files.emplace_back(fs::relative(entry.path(), folder).string(), read_file(entry.path()));
  std::sort(files.begin(), files.end());
  return files;
}

void add_outputs(const fs::path& scratch, std::vector<FuzzedReader>& readers) {
  write_regions(scratch / "regions", {{kSkin, kHair, kUnlabelled}, "abc", "z"});
  const auto regions = files_below(scratch / "regions");
  readers.push_back(
      {"Regions", regions, regions.size(), [](const fs::path& folder) { read_regions(folder); }});
  Model model = grid_model(
      2, 2,
      [](float u, float v) {
        return Vec3f{u, v, 0};
      },
      constant_set({}));
  fs::create_directories(scratch / "model");
  write_model(scratch / "model", model);
  const auto files = files_below(scratch / "model");
  readers.push_back({"Model", files, files.size(), [](const fs::path& folder) { read_model(folder); }});
  Sample sample;
  for (const auto& [image, channels] : {std::pair(&sample.mask, 1),
                                        {&sample.normal, 3},
                                        {&sample.diffuse, 3},
                                        {&sample.roughness, 1},
                                        {&sample.specular, 1},
                                        {&sample.sss, 1},
                                        {&sample.displacement, 1},
                                        {&sample.classes, 4}})
    *image = Image(4, 4, channels);
  sample.lights = {{"sky", Image(4, 4, 3)}};
  sample.attributes = {{"ohb:human", "a"}, {"ohb:view", "0"}, {"ohb:viewCount", "1"}};
  write_sample(scratch / "view.exr", sample);
  readers.push_back(
      {"Sample", {{"view.exr", read_file(scratch / "view.exr")}}, 1, [](const fs::path& folder) {
         read_sample(folder / "view.exr");
       }});
  readers.push_back({"Environments", {{"envmaps.xml", kEnvironments}}, 1, [](const fs::path& folder) {
                       environments::read_library(folder);
                     }});
  const std::string identity = identity_of({{"ohb:human", "ann"}});
  sample.attributes = {{"ohb:human", "ann"}, {"ohb:identity", identity}, {"ohb:view", "0"}};
  write_sample(scratch / "listed.exr", sample);
  const std::string listing = "{\"identity\": \"" + identity +
                              "\", \"settings\": {\"ohb:human\": \"ann\"}, \"views\": [{\"file\": "
                              "\"view_000.exr\"}]}";
  readers.push_back({"Dataset",
                     {{"dataset.xml", kDataset},
                      {"v/render.json", listing},
                      {"v/view_000.exr", read_file(scratch / "listed.exr")}},
                     3,
                     [](const fs::path& folder) { exports::index_samples(folder); }});
}

void add_catalogues(std::vector<FuzzedReader>& readers) {
  const fs::path stress = source_path("assets/stress");
  readers.push_back({"BakeCatalogue",
                     {{"c.json", read_file(stress / "bake_catalogue.json")}},
                     1,
                     [](const fs::path& folder) { read_bake_stress_catalogue(folder / "c.json"); }});
  readers.push_back(
      {"StressCatalogue", {{"c.json", read_file(stress / "catalogue.json")}}, 1, [](const fs::path& folder) {
         read_stress_catalogue(folder / "c.json");
       }});
}

}  // namespace

std::vector<FuzzedReader> fuzzed_readers(const fs::path& scratch) {
  std::vector<FuzzedReader> readers;
  add_pictures(scratch, readers);
  add_scans(readers);
  add_labels(readers);
  add_outputs(scratch, readers);
  add_catalogues(readers);
  return readers;
}

}  // namespace ohb
