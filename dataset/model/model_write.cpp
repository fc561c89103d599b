// Writes a MODEL folder.
#include <algorithm>
#include <cctype>
#include <cstring>
#include <set>
#include <stdexcept>
#include <utility>

#include "dataset/model/atomic_file.h"
#include "dataset/model/colour.h"
#include "dataset/model/conventions.h"
#include "dataset/model/error.h"
#include "dataset/model/model_files.h"
#include "dataset/model/parallel.h"
#include "dataset/model/xml_document.h"

namespace ohb {
namespace fs = std::filesystem;
namespace {

constexpr int kPreviewEdge_px = 1024;

/// Averages blocks of whole texels so that the longer edge has at most kPreviewEdge_px.
template <int kChannels>
Image preview_of_channels(const Image& image) {
  const int block = (std::max(image.width_px, image.height_px) + kPreviewEdge_px - 1) / kPreviewEdge_px;
  Image small(std::max(1, image.width_px / block), std::max(1, image.height_px / block), kChannels);
  const int columns = std::min(block, image.width_px), rows = std::min(block, image.height_px);
  parallel_for_each(0, small.height_px, [&](int y) {
    for (int x = 0; x < small.width_px; ++x) {
      float sum[kChannels] = {};
      for (int dy = 0; dy < rows; ++dy) {
        const float* const in = image.pixel(x * block, y * block + dy);
        for (int i = 0; i < columns; ++i)
          for (int c = 0; c < kChannels; ++c) sum[c] += in[i * kChannels + c];
      }
      for (int c = 0; c < kChannels; ++c) small.pixel(x, y)[c] = sum[c] / static_cast<float>(columns * rows);
    }
  });
  return small;
}

Image preview_of(const Image& image) {
  return image.channels == 1 ? preview_of_channels<1>(image) : preview_of_channels<3>(image);
}

Image flat_normals(int width_px, int height_px) {
  Image image(width_px, height_px, 3);
  for (size_t i = 2; i < image.values.size(); i += 3) image.values[i] = 1;
  return image;
}

/// The preview's values as a PNG shows them: sRGB colours, normals around one half, displacement stretched.
void encode_preview(const std::string& map, Image& preview) {
  if (map == "albedo")
    for (float& value : preview.values) value = linear_to_srgb(std::clamp(value, 0.0f, 1.0f));
  if (map == "normal")
    for (float& value : preview.values) value = 0.5f + 0.5f * value;
  if (map == "displacement") {
    float reach = 1e-6f;
    for (float value : preview.values) reach = std::max(reach, std::abs(value));
    for (float& value : preview.values) value = 0.5f + 0.5f * value / reach;
  }
}

ByteImage bytes_of(const Image& image) {
  ByteImage bytes(image.width_px, image.height_px, image.channels);
  std::transform(image.values.begin(), image.values.end(), bytes.values.begin(), [](float value) {
    return static_cast<uint8_t>(std::floor(255 * (value > 0 ? std::min(value, 1.0f) : 0.0f) + 0.5f));
  });
  return bytes;
}

/// Lossless. On noisy scans of 4096 x 4096 texels zip at its lowest effort takes 1.5 s of a core for a colour
/// map; piz takes a third of it and 15 % less space. Noisy normals cost piz as much as zip: run lengths take
/// a quarter of it and 27 % more space. Positions in float hardly compress.
const char* compression_of(const MapKind& kind) {
  if (kind.is_float) return "none";
  return kind.image == &TextureSet::normal ? "rle" : "piz";
}

std::string faces_bin(const Model& model) {
  const uint32_t count = static_cast<uint32_t>(model.triangles.size());
  std::string bytes = "OHBFACE1";
  bytes.append(reinterpret_cast<const char*>(&count), sizeof count);
  for (const ModelTriangle& triangle : model.triangles)
    bytes.append(reinterpret_cast<const char*>(&triangle.source_face), sizeof triangle.source_face);
  for (const ModelTriangle& triangle : model.triangles) bytes += static_cast<char>(triangle.material_class);
  return bytes;
}

std::string mtl_text(const std::vector<TextureSetEntry>& sets) {
  std::string text = "# previews only; model.xml names the maps that count\n";
  for (const TextureSetEntry& set : sets) {
    const std::string previews = "maps/" + set.folder + "/previews/";
    text += "newmtl " + set.folder + "\nKd 1 1 1\nillum 1\nmap_Kd " + previews + "albedo.png\n";
    if (std::find(set.maps.begin(), set.maps.end(), "alpha") != set.maps.end())
      text += "map_d " + previews + "alpha.png\n";
    if (std::find(set.maps.begin(), set.maps.end(), "normal") != set.maps.end())
      text += "norm " + previews + "normal.png\n";
  }
  return text;
}

std::string model_xml(const Model& model, const std::vector<TextureSetEntry>& sets) {
  pugi::xml_document document;
  pugi::xml_node root = document.append_child("model");
  root.append_attribute("schema") = "1.0";
  root.append_attribute("name") = model.name.c_str();
  root.append_child("generator").append_attribute("version") = OHB_VERSION;
  pugi::xml_node source = root.append_child("source");
  source.append_attribute("file") = model.source_file.c_str();
  source.append_attribute("sha256") = model.source_sha256.c_str();
  source.append_attribute("unit_cm") = shortest(model.source_unit_cm).c_str();
  const char* const shift_names[3] = {"shift_x_cm", "shift_y_cm", "shift_z_cm"};
  for (int i = 0; i < 3; ++i)
    source.append_attribute(shift_names[i]) = shortest(model.source_shift_cm[i]).c_str();
  if (!model.source_up.empty()) source.append_attribute("up") = model.source_up.c_str();
  append_conventions(root);
  pugi::xml_node mesh = root.append_child("mesh");
  mesh.append_attribute("file") = "mesh.obj";
  mesh.append_attribute("faces") = "faces.bin";
  mesh.append_attribute("positions") = static_cast<unsigned long long>(model.positions_cm.size());
  mesh.append_attribute("uvs") = static_cast<unsigned long long>(model.uvs.size());
  mesh.append_attribute("triangles") = static_cast<unsigned long long>(model.triangles.size());
  for (const TextureSetEntry& set : sets) {
    pugi::xml_node node = root.append_child("texture_set");
    node.append_attribute("name") = set.name.c_str();
    node.append_attribute("folder") = set.folder.c_str();
    node.append_attribute("width_px") = set.width_px;
    node.append_attribute("height_px") = set.height_px;
    for (const std::string& map : set.maps) node.append_child("map").append_attribute("name") = map.c_str();
  }
  return xml_text(document);
}

}  // namespace

std::vector<std::string> texture_set_folders(const std::vector<std::string>& names) {
  constexpr size_t kLongestName = 64;
  std::vector<std::string> folders;
  std::set<std::string> used;
  for (const std::string& name : names) {
    std::string folder = name.substr(0, kLongestName);
    for (char& c : folder)
      if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '.') c = '_';
    if (folder.empty()) folder = "set";
    if (folder[0] == '.') folder[0] = '_';
    const auto lower = [](std::string text) {
      std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
      return text;
    };
    std::string unique = folder;
    for (int i = 2; !used.insert(lower(unique)).second; ++i) unique = folder + "_" + std::to_string(i);
    folders.push_back(unique);
  }
  return folders;
}

bool write_texture_map(const fs::path& folder, const MapKind& kind, Image image, const TextureSetEntry& entry,
                       std::vector<Image> mips) {
  const fs::path maps = folder / "maps" / entry.folder, previews = maps / "previews";
  make_folders(previews);
  // All maps are on disk, but a flat normal map is not named in model.xml: nobody need sample it.
  const bool is_flat_normal = image.values.empty() && kind.image == &TextureSet::normal;
  if (is_flat_normal) image = flat_normals(entry.width_px, entry.height_px);
  if (image.values.empty() && kind.is_optional) return false;
  if (image.width_px != entry.width_px || image.height_px != entry.height_px ||
      image.channels != kind.channels)
    throw std::logic_error("texture set '" + entry.name + "': map " + kind.name + " has a wrong size");
  Image preview = preview_of(image);
  encode_preview(kind.name, preview);
  write_png(previews / (std::string(kind.name) + ".png"), bytes_of(preview));
  ExrPart part{
      kind.name, kind.channels == 3 ? std::vector<std::string>{"R", "G", "B"} : std::vector<std::string>{"Y"},
      kind.is_float ? ExrPart::Type::kFloat : ExrPart::Type::kHalf, std::move(image), std::move(mips)};
  std::vector<ExrPart> parts;
  parts.push_back(std::move(part));
  write_exr(maps / (std::string(kind.name) + ".exr"), parts,
            {{"compression", is_flat_normal ? "piz" : compression_of(kind)}});
  return !is_flat_normal;
}

TextureSetEntry write_texture_set(const fs::path& folder, const std::string& set_folder, TextureSet&& set) {
  TextureSetEntry entry{set.name, set_folder, set.valid.width_px, set.valid.height_px, {}};
  for (const MapKind& kind : kMapKinds)
    if (write_texture_map(folder, kind, std::exchange(set.*kind.image, Image()), entry))
      entry.maps.push_back(kind.name);
  write_png(folder / "maps" / set_folder / "valid.png", set.valid);
  set.valid = Image();
  return entry;
}

void write_model_mesh(const fs::path& folder, const Model& model, const std::vector<TextureSetEntry>& sets) {
  const std::string fault = mesh_fault(model, sets.size());
  if (!fault.empty()) throw std::logic_error("write_model: " + fault);
  if (!model.normals.empty()) throw std::logic_error("write_model: normals are not stored");
  make_folders(folder);
  write_file_atomically(folder / "mesh.obj", mesh_obj_text(model, sets));
  write_file_atomically(folder / "mesh.mtl", mtl_text(sets));
  write_file_atomically(folder / "faces.bin", faces_bin(model));
  write_file_atomically(folder / "model.xml", model_xml(model, sets));
}

void write_model(const fs::path& folder, const Model& model) {
  std::vector<std::string> names;
  for (const TextureSet& set : model.sets) names.push_back(set.name);
  const std::vector<std::string> folders = texture_set_folders(names);
  std::vector<TextureSetEntry> entries;
  for (size_t i = 0; i < folders.size(); ++i)
    entries.push_back(write_texture_set(folder, folders[i], TextureSet(model.sets[i])));
  write_model_mesh(folder, model, entries);
}

}  // namespace ohb
