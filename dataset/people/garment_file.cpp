#include "dataset/people/garment_file.h"

#include <fmt/format.h>

#include <cmath>

#include "dataset/model/error.h"
#include "dataset/people/asset_file.h"

namespace ohb::people {
namespace fs = std::filesystem;
namespace {

constexpr const char* kMend = "take the asset from MakeHuman's packs again";

/// Reads a .mhclo; the keys come first, then a line for each vertex, then the vertices that it hides.
class GarmentReader {
 public:
  GarmentReader(const fs::path& assets, const fs::path& file, size_t base_vertex_count)
      : assets_(assets),
        file_(file),
        count_(base_vertex_count),
        text_(read_asset_text(file)),
        lines_(file, text_) {
    garment_.file = file;
    garment_.name = file.stem().string();
    garment_.hides.assign(count_, 0);
  }

  Garment read() {
    while (lines_.next()) {
      const std::string key(lines_.word());
      if (hides_ && is_number(key)) {
        read_hidden(key);
      } else if (in_anchors_ && is_number(key)) {
        read_anchor(key);
      } else {
        read_key(key);
      }
    }
    if (garment_.mesh.face_count() == 0) throw InputError(file_.string(), "", "names no obj_file", kMend);
    if (garment_.anchors.size() != garment_.mesh.positions.size())
      throw InputError(file_.string(), "",
                       fmt::format("{} vertices are placed, and the mesh has {}", garment_.anchors.size(),
                                   garment_.mesh.positions.size()),
                       kMend);
    return std::move(garment_);
  }

 private:
  static bool is_number(const std::string& word) {
    return !word.empty() && (std::isdigit(static_cast<unsigned char>(word[0])) != 0 || word[0] == '-');
  }

  void read_key(const std::string& key) {
    if (key == "name") garment_.name = lines_.rest();
    if (key == "z_depth") garment_.z_depth = lines_.number("z_depth");
    if (key == "obj_file") read_mesh(lines_.rest());
    if (key == "material")
      garment_.material = read_asset_material(assets_, asset_path(assets_, file_, lines_.rest()));
    if (key == "x_scale" || key == "y_scale" || key == "z_scale") read_scale(key[0] - 'x');
    if (key == "verts") in_anchors_ = true;
    if (key == "delete_verts") hides_ = true;
  }

  void read_mesh(const std::string& name) {
    garment_.mesh = read_scan(asset_path(assets_, file_, name));
    for (const Corner& corner : garment_.mesh.corners)
      if (corner.uv == Corner::kNoUv)
        throw InputError(garment_.mesh.file.string(), "", "has faces without UVs", kMend);
  }

  void read_scale(int axis) {
    ScaleLine scale;
    scale.a = lines_.index("base vertex", count_);
    scale.b = lines_.index("base vertex", count_);
    scale.made_for = lines_.number("size");
    if (!(scale.made_for > 0)) lines_.fail("the size is not above 0");
    garment_.scale[static_cast<size_t>(axis)] = scale;
  }

  uint32_t base_vertex(const std::string& word) const {
    long long value = -1;
    if (!parse_integer(word, value) || value < 0 || static_cast<size_t>(value) >= count_)
      lines_.fail(fmt::format("the base vertex is '{}', and there are {}", word.substr(0, 40), count_));
    return static_cast<uint32_t>(value);
  }

  void read_anchor(const std::string& first) {
    const uint32_t vertex = base_vertex(first);
    Anchor anchor{{vertex, vertex, vertex}, {1, 0, 0}, {}};
    if (!lines_.is_at_end()) {
      for (size_t i = 1; i < 3; ++i) anchor.vertices[i] = lines_.index("base vertex", count_);
      for (float& weight : anchor.weights) weight = lines_.number("weight");
      for (int axis = 0; axis < 3; ++axis) anchor.offset[axis] = lines_.number("offset");
    }
    garment_.anchors.push_back(anchor);
  }

  /// "12 15 - 20 33"
  void read_hidden(std::string word) {
    uint32_t first = 0, last = 0;
    while (!word.empty()) {
      if (word == "-") {
        last = base_vertex(std::string(lines_.word()));
        if (last < first) lines_.fail("a range of hidden vertices runs backwards");
      } else {
        first = last = base_vertex(word);
      }
      for (uint32_t v = first; v <= last; ++v) garment_.hides[v] = 1;
      word = std::string(lines_.word());
    }
  }

  fs::path assets_, file_;
  size_t count_;
  std::string text_;
  AssetLines lines_;
  Garment garment_;
  bool in_anchors_ = false, hides_ = false;
};

}  // namespace

Garment read_garment(const fs::path& assets, const fs::path& file, size_t base_vertex_count) {
  return GarmentReader(assets, file, base_vertex_count).read();
}

AssetMaterial read_asset_material(const fs::path& assets, const fs::path& file) {
  const std::string text = read_asset_text(file);
  AssetLines lines(file, text);
  AssetMaterial material;
  material.file = file;
  while (lines.next()) {
    const std::string key(lines.word());
    if (key == "diffuseTexture") material.diffuse = asset_path(assets, file, lines.rest());
    if (key == "diffuseColor")
      for (int channel = 0; channel < 3; ++channel) material.diffuse_colour[channel] = lines.number("colour");
  }
  return material;
}

std::vector<Vec3f> fitted(const Garment& garment, const std::vector<Vec3f>& base) {
  Vec3f scale{1, 1, 1};
  for (int axis = 0; axis < 3; ++axis)
    if (const auto& line = garment.scale[static_cast<size_t>(axis)])
      scale[axis] = std::fabs(base[line->a][axis] - base[line->b][axis]) / line->made_for;
  std::vector<Vec3f> positions;
  positions.reserve(garment.anchors.size());
  for (const Anchor& anchor : garment.anchors) {
    Vec3f at = anchor.offset * scale;
    for (size_t i = 0; i < 3; ++i) at += anchor.weights[i] * base[anchor.vertices[i]];
    positions.push_back(at);
  }
  return positions;
}

}  // namespace ohb::people
