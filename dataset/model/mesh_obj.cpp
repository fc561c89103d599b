// mesh.obj of a model: the small, strict part of the OBJ format that we write ourselves.
#include <charconv>
#include <unordered_map>

#include "dataset/model/error.h"
#include "dataset/model/model_files.h"

namespace ohb {
namespace {

template <typename Number>
void append(std::string& text, char before, Number value) {
  char digits[32];
  text += before;
  text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

/// Walks through one line; `ok` turns false at the first thing that is not as expected.
struct LineReader {
  const char* at;
  const char* end;
  bool ok = true;

  bool skip(char c) {
    ok = ok && at != end && *at == c;
    if (ok) ++at;
    return ok;
  }
  template <typename Number>
  Number number() {
    Number value{};
    const auto [rest, failure] = std::from_chars(at, end, value);
    ok = ok && failure == std::errc();
    at = rest;
    return value;
  }
  float coordinate() {
    skip(' ');
    return number<float>();
  }
  /// A 1-based index, given back 0-based.
  uint32_t index(char before) {
    skip(before);
    const uint32_t value = number<uint32_t>();
    ok = ok && value > 0;
    return value - 1;
  }
};

bool starts_with(std::string_view line, std::string_view word) {
  return line.substr(0, word.size()) == word;
}

/// Adds to a model what the lines of its mesh.obj say, one after the other.
class ElementReader {
 public:
  ElementReader(const std::vector<TextureSetEntry>& sets, Model& model) : model_(model) {
    for (size_t i = 0; i < sets.size(); ++i) set_of_name_[sets[i].folder] = static_cast<uint16_t>(i);
  }

  /// False if the line is not as expected.
  bool read(std::string_view line) {
    LineReader reader{line.data(), line.data() + line.size()};
    if (starts_with(line, "usemtl ")) return use_set(std::string(line.substr(7)));
    if (starts_with(line, "v ")) {
      reader.at += 1;
      const float x = reader.coordinate(), y = reader.coordinate(), z = reader.coordinate();
      model_.positions_cm.push_back({x, y, z});
    } else if (starts_with(line, "vt ")) {
      reader.at += 2;
      const float u = reader.coordinate(), v = reader.coordinate();
      model_.uvs.push_back({u, v});
    } else if (starts_with(line, "f ")) {
      reader.at += 1;
      add_triangle(reader);
    } else {
      return false;
    }
    return reader.ok && reader.at == reader.end;
  }

 private:
  bool use_set(const std::string& name) {
    const auto found = set_of_name_.find(name);
    if (found != set_of_name_.end()) set_ = found->second;
    return found != set_of_name_.end();
  }

  void add_triangle(LineReader& reader) {
    ModelTriangle triangle{};
    for (int c = 0; c < 3; ++c) {
      triangle.position[c] = reader.index(' ');
      triangle.uv[c] = reader.index('/');
    }
    reader.ok = reader.ok && set_ >= 0;
    triangle.set = static_cast<uint16_t>(std::max(set_, 0));
    model_.triangles.push_back(triangle);
  }

  Model& model_;
  std::unordered_map<std::string, uint16_t> set_of_name_;
  int set_ = -1;  // no usemtl yet
};

}  // namespace

std::string mesh_obj_text(const Model& model, const std::vector<TextureSetEntry>& sets) {
  std::string text = "# openhumanbrdf model: centimetres, Y up, facing +Z\nmtllib mesh.mtl\n";
  text.reserve(model.positions_cm.size() * 36 + model.uvs.size() * 26 + model.triangles.size() * 44);
  for (const Vec3f& p : model.positions_cm) {
    text += 'v';
    for (int i = 0; i < 3; ++i) append(text, ' ', p[i]);
    text += '\n';
  }
  for (const Vec2f& uv : model.uvs) {
    text += "vt";
    append(text, ' ', uv.x);
    append(text, ' ', uv.y);
    text += '\n';
  }
  int set = -1;
  for (const ModelTriangle& triangle : model.triangles) {
    if (triangle.set != set) text += "usemtl " + sets.at(set = triangle.set).folder + "\n";
    text += 'f';
    for (int c = 0; c < 3; ++c) {
      append(text, ' ', uint64_t{triangle.position[c]} + 1);
      append(text, '/', uint64_t{triangle.uv[c]} + 1);
    }
    text += '\n';
  }
  return text;
}

void parse_mesh_obj(const std::string& text, const std::filesystem::path& file,
                    const std::vector<TextureSetEntry>& sets, Model& model) {
  ElementReader elements(sets, model);
  size_t line_number = 0;
  for (size_t begin = 0; begin < text.size();) {
    const size_t newline = std::min(text.find('\n', begin), text.size());
    std::string_view line(text.data() + begin, newline - begin);
    begin = newline + 1;
    ++line_number;
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.empty() || line[0] == '#' || starts_with(line, "mtllib ")) continue;
    if (!elements.read(line))
      throw InputError(file.string(), "line " + std::to_string(line_number),
                       "\"" + std::string(line.substr(0, 60)) + "\" is not what a model's mesh holds there",
                       "bake the model again");
  }
}

}  // namespace ohb
