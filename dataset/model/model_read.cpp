// Reads a MODEL folder and checks everything in it.
#include <cmath>
#include <cstring>
#include <exception>
#include <functional>

#include "dataset/model/atomic_file.h"
#include "dataset/model/conventions.h"
#include "dataset/model/error.h"
#include "dataset/model/model_files.h"
#include "dataset/model/parallel.h"
#include "dataset/model/xml_document.h"

namespace ohb {
namespace fs = std::filesystem;
namespace {

constexpr const char* kBakeAgain = "bake the model again";
constexpr uint64_t kMaxCount = 0xffffffffu;

bool is_portable_name(const std::string& folder) {
  return !folder.empty() && folder[0] != '.' && folder.find_first_of("/\\") == std::string::npos;
}

TextureSetEntry read_set_entry(const XmlDocument& xml, pugi::xml_node node) {
  xml.expect_attributes(node, {"name", "folder", "width_px", "height_px"});
  TextureSetEntry entry{xml.text(node, "name"),
                        xml.text(node, "folder"),
                        static_cast<int>(xml.count(node, "width_px", 65536)),
                        static_cast<int>(xml.count(node, "height_px", 65536)),
                        {}};
  if (!is_portable_name(entry.folder))
    throw xml.error(node, "folder=\"" + entry.folder + "\" is no plain folder name", kBakeAgain);
  if (entry.width_px < 1 || entry.height_px < 1) throw xml.error(node, "a map without texels", kBakeAgain);
  for (const pugi::xml_node& map : node.children("map")) entry.maps.push_back(xml.text(map, "name"));
  return entry;
}

/// What model.xml states besides the sets.
struct MeshCounts {
  uint64_t positions, uvs, triangles;
};

MeshCounts read_header(const XmlDocument& xml, Model& model) {
  xml.expect_attributes(xml.root(), {"schema", "name"});
  const std::string schema = xml.text(xml.root(), "schema");
  if (schema.rfind("1.", 0) != 0)
    throw xml.error(xml.root(), "schema " + schema + " is not known here (1.x is)", "use a newer version");
  const pugi::xml_node conventions = xml.child(xml.root(), "conventions");
  if (xml.count(conventions, "version", 1000) != kConventionsVersion)
    throw xml.error(conventions,
                    "conventions of version " + xml.text(conventions, "version") + ", this is " +
                        std::to_string(kConventionsVersion),
                    kBakeAgain);
  model.name = xml.text(xml.root(), "name");
  const pugi::xml_node source = xml.child(xml.root(), "source");
  model.source_file = xml.text(source, "file");
  model.source_sha256 = xml.text(source, "sha256");
  model.source_up = xml.text_or(source, "up", "");
  model.source_unit_cm = xml.number(source, "unit_cm", 1e-9, 1e9);
  model.source_shift_cm = {static_cast<float>(xml.number(source, "shift_x_cm", -1e9, 1e9)),
                           static_cast<float>(xml.number(source, "shift_y_cm", -1e9, 1e9)),
                           static_cast<float>(xml.number(source, "shift_z_cm", -1e9, 1e9))};
  const pugi::xml_node mesh = xml.child(xml.root(), "mesh");
  return {xml.count(mesh, "positions", kMaxCount), xml.count(mesh, "uvs", kMaxCount),
          xml.count(mesh, "triangles", kMaxCount)};
}

void expect_count(const fs::path& file, const char* what, size_t found, uint64_t stated) {
  if (found != stated)
    throw InputError(
        file.string(), "",
        "holds " + std::to_string(found) + " " + what + ", model.xml states " + std::to_string(stated),
        kBakeAgain);
}

void read_faces_bin(const fs::path& file, Model& model) {
  const std::string bytes = read_file(file);
  const size_t count = model.triangles.size(), header = 12;
  uint32_t stated = 0;
  if (bytes.size() >= header) std::memcpy(&stated, bytes.data() + 8, sizeof stated);
  if (bytes.compare(0, 8, "OHBFACE1") != 0 || stated != count || bytes.size() != header + 5 * count)
    throw InputError(file.string(), "",
                     "does not hold the classes of " + std::to_string(count) + " triangles", kBakeAgain);
  for (size_t i = 0; i < count; ++i) {
    std::memcpy(&model.triangles[i].source_face, bytes.data() + header + 4 * i, 4);
    model.triangles[i].material_class = static_cast<uint8_t>(bytes[header + 4 * count + i]);
  }
}

void expect_finite(const fs::path& file, const Image& image) {
  for (size_t i = 0; i < image.values.size(); ++i)
    if (!std::isfinite(image.values[i])) {
      const size_t texel = i / image.channels, width = image.width_px;
      throw InputError(file.string(),
                       "texel (" + std::to_string(texel % width) + ", " + std::to_string(texel / width) + ")",
                       "is not a finite number", kBakeAgain);
    }
}

void expect_size(const fs::path& file, const Image& image, const TextureSetEntry& entry, int channels) {
  if (image.width_px == entry.width_px && image.height_px == entry.height_px && image.channels == channels)
    return;
  const auto size = [](int width, int height, int channel_count) {
    return std::to_string(width) + " x " + std::to_string(height) + " x " + std::to_string(channel_count);
  };
  throw InputError(file.string(), "",
                   "is " + size(image.width_px, image.height_px, image.channels) + ", model.xml states " +
                       size(entry.width_px, entry.height_px, channels),
                   kBakeAgain);
}

/// One image file of a set: a map, or the validity mask where kind is null.
void read_map(const fs::path& maps, const TextureSetEntry& entry, const MapKind* kind, TextureSet& set) {
  const fs::path file = maps / entry.folder / (kind ? std::string(kind->name) + ".exr" : "valid.png");
  Image image = kind ? read_exr_image(file) : read_image(file);
  expect_size(file, image, entry, kind ? kind->channels : 1);
  expect_finite(file, image);
  if (!kind)
    for (float& value : image.values) value = value < 0.25f ? 0.0f : value > 0.75f ? 1.0f : 0.5f;
  (kind ? set.*kind->image : set.valid) = std::move(image);
}

/// What reads the maps into `sets`.
std::vector<std::function<void()>> map_tasks(const fs::path& maps, const XmlDocument& xml,
                                             const std::vector<TextureSetEntry>& entries, ModelParts parts,
                                             std::vector<TextureSet>& sets) {
  std::vector<std::function<void()>> tasks;
  const bool all = parts == ModelParts::kAll;
  for (size_t i = 0; i < entries.size(); ++i) {
    const auto add = [&](const MapKind* kind) {
      tasks.push_back(
          [&maps, &entry = entries[i], kind, &set = sets[i]] { read_map(maps, entry, kind, set); });
    };
    for (const MapKind& kind : kMapKinds) {
      const bool stated =
          std::find(entries[i].maps.begin(), entries[i].maps.end(), kind.name) != entries[i].maps.end();
      if (stated && (all || kind.image != &TextureSet::displacement)) add(&kind);
      if (!stated && !kind.is_optional)
        throw InputError(xml.file().string(), "texture set '" + entries[i].name + "'",
                         "has no map '" + std::string(kind.name) + "'", kBakeAgain);
    }
    if (all) add(nullptr);
  }
  return tasks;
}

void read_mesh(const fs::path& folder, const MeshCounts& counts, const std::vector<TextureSetEntry>& entries,
               Model& model) {
  const fs::path file = folder / "mesh.obj";
  parse_mesh_obj(read_file(file), file, entries, model);
  expect_count(file, "positions", model.positions_cm.size(), counts.positions);
  expect_count(file, "UVs", model.uvs.size(), counts.uvs);
  expect_count(file, "triangles", model.triangles.size(), counts.triangles);
  read_faces_bin(folder / "faces.bin", model);
  const std::string fault = mesh_fault(model, entries.size());
  if (!fault.empty()) throw InputError(file.string(), "", fault, kBakeAgain);
}

/// All of them on all threads. The first failure in their order is thrown, whatever the threads do.
void run_all(const std::vector<std::function<void()>>& tasks) {
  std::vector<std::exception_ptr> failures(tasks.size());
  parallel_for_each(0, static_cast<int>(tasks.size()), [&](int task) {
    const auto i = static_cast<size_t>(task);
    try {
      tasks[i]();
    } catch (...) {
      failures[i] = std::current_exception();
    }
  });
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

}  // namespace

Model read_model(const fs::path& folder, ModelParts parts) {
  if (!fs::is_directory(folder))
    throw InputError(folder.string(), "", "no such folder", "give the folder that `bake -o` wrote");
  const XmlDocument xml(folder / "model.xml", "model");
  Model model;
  const MeshCounts counts = read_header(xml, model);
  std::vector<TextureSetEntry> entries;
  for (const pugi::xml_node& node : xml.root().children("texture_set"))
    entries.push_back(read_set_entry(xml, node));
  if (entries.empty()) throw xml.error(xml.root(), "there is no texture set", kBakeAgain);

  model.sets.resize(entries.size());
  for (size_t i = 0; i < entries.size(); ++i) model.sets[i].name = entries[i].name;
  const fs::path maps = folder / "maps";
  auto tasks = map_tasks(maps, xml, entries, parts, model.sets);
  tasks.insert(tasks.begin(), [&] { read_mesh(folder, counts, entries, model); });
  run_all(tasks);
  return model;
}

}  // namespace ohb
