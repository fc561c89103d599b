// Wavefront OBJ. Read here and not by a library because labels index faces and corners in source order,
// positions must be the nearest floats, and an error must name its line.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <unordered_map>

#include "dataset/model/atomic_file.h"
#include "dataset/model/colour.h"
#include "dataset/model/error.h"
#include "dataset/model/scan_readers.h"
#include "dataset/model/text_lines.h"

namespace ohb {
namespace {

class ObjReader {
 public:
  ObjReader(const std::filesystem::path& file, std::string_view text)
      : file_(file), lines_(file, text), files_(scan_) {
    scan_.file = file;
  }

  Scan read() {
    while (lines_.next()) read_line(lines_.line());
    close_faces(scan_);
    check_indices();
    resolve_materials();
    store_positions(scan_, positions_);
    take_vertex_colours();
    if (scan_.groups.empty()) scan_.groups.push_back("default");
    return std::move(scan_);
  }

 private:
  [[noreturn]] void fail(const std::string& cause, const std::string& mend = "") const {
    throw InputError(file_.string(), lines_.place(), cause, mend);
  }

  void read_line(std::string_view line) {
    if (line.empty() && lines_.comment().substr(0, 6) == "#MRGB ") read_mrgb(lines_.comment().substr(6));
    const std::string_view keyword = next_word(line);
    if (keyword == "v") {
      read_position(line);
    } else if (keyword == "vt") {
      read_uv(line);
    } else if (keyword == "vn") {
      scan_.has_file_normals = true;
    } else if (keyword == "f") {
      read_face(line);
    } else if (keyword == "usemtl") {
      material_ = index_of(std::string(lines_.name()), material_names_, material_indices_, "materials");
    } else if (keyword == "g" || keyword == "o") {
      group_name_ = std::string(lines_.name());
      group_known_ = false;
    } else if (keyword == "mtllib") {
      read_materials(std::string(lines_.name()));
    }
  }

  /// Gives how many there were.
  int read_numbers(std::string_view line, const char* what, int wanted, int at_least, double* values) {
    for (int i = 0; i < wanted; ++i) {
      const std::string_view word = next_word(line);
      if (word.empty() && i >= at_least) return i;
      if (word.empty())
        fail(std::string(what) + " has " + std::to_string(i) + " numbers instead of " +
                 std::to_string(at_least),
             "export the scan again: the line is cut off");
      float single = 0;
      if (!parse_float(word, single) || !parse_double(word, values[i]))
        fail(std::string(what) + ": '" + std::string(word.substr(0, 40)) + "' is no number",
             "numbers have a decimal point and fit a 32-bit float");
    }
    return wanted;
  }

  void check_room(size_t count, const char* what) const {
    if (count >= kMaxScanElements)
      fail("more than " + std::to_string(kMaxScanElements) + " " + what, "reduce the scan");
  }

  void read_position(std::string_view line) {
    check_room(positions_.size(), "vertices");
    double values[6] = {0, 0, 0, 0, 0, 0};
    const int count = read_numbers(line, "vertex", 6, 3, values);
    if (!std::isfinite(values[0]) || !std::isfinite(values[1]) || !std::isfinite(values[2]))
      fail(numbered("vertex", positions_.size()) + " is not finite", "remove the vertex and its faces");
    positions_.push_back({values[0], values[1], values[2]});
    if (count < 6) return;  // a fourth number is a weight
    if (!(values[3] >= 0 && values[4] >= 0 && values[5] >= 0 &&
          std::max({values[3], values[4], values[5]}) <= 255))
      fail(numbered("vertex", positions_.size() - 1) + " has a colour that is none",
           "colours are from 0 to 1 or from 0 to 255");
    colours_.resize(positions_.size(), kNoColour);
    colours_.back() = {static_cast<float>(values[3]), static_cast<float>(values[4]),
                       static_cast<float>(values[5])};
  }

  /// ZBrush: "#MRGB" and eight hexadecimal digits a vertex, mask and colour.
  void read_mrgb(std::string_view digits) {
    for (; digits.size() >= 8 && colours_.size() < kMaxScanElements; digits.remove_prefix(8)) {
      uint32_t value = 0;
      const auto read = std::from_chars(digits.data(), digits.data() + 8, value, 16);
      if (read.ec != std::errc() || read.ptr != digits.data() + 8) return;
      colours_.push_back({static_cast<float>(value >> 16 & 255) / 255,
                          static_cast<float>(value >> 8 & 255) / 255, static_cast<float>(value & 255) / 255});
    }
  }

  /// Colours are sRGB, as Blender takes them. Faces with a colour at each corner are coloured.
  void take_vertex_colours() {
    if (colours_.empty()) return;
    colours_.resize(positions_.size(), kNoColour);
    float largest = 0;
    for (Vec3f c : colours_) largest = std::max({largest, c.x, c.y, c.z});
    const float scale = largest > 1 ? 1.0f / 255 : 1;
    if (largest > 1) scan_.notes.push_back("colours at the vertices are taken as 0 to 255");
    std::vector<bool> is_coloured(scan_.face_count(), true);
    scan_.corner_colours.resize(scan_.corners.size());
    for (size_t f = 0; f < scan_.face_count(); ++f)
      for (size_t c = scan_.face_begin[f]; c < scan_.face_begin[f + 1]; ++c) {
        const Vec3f from = colours_[scan_.corners[c].position];
        if (from.x < 0) is_coloured[f] = false;
        for (int k = 0; k < 3; ++k)
          scan_.corner_colours[c].rgb[k] = srgb_to_linear(std::max(0.0f, from[k] * scale));
      }
    settle_vertex_colours(scan_, is_coloured);
  }

  void read_uv(std::string_view line) {
    check_room(scan_.uvs.size(), "UVs");
    double uv[2] = {0, 0};
    read_numbers(line, "UV", 2, 1, uv);
    scan_.uvs.push_back({static_cast<float>(uv[0]), static_cast<float>(uv[1])});
    if (!is_finite(scan_.uvs.back()))
      fail(numbered("UV", scan_.uvs.size() - 1) + " is not finite", "unwrap its faces again");
  }

  /// OBJ counts from 1; negative indices count back from the latest element.
  uint32_t read_index(std::string_view word, size_t latest, const char* what) const {
    long long index = 0;
    if (!parse_integer(word, index))
      fail(std::string("face: '") + std::string(word.substr(0, 40)) + "' is no " + what + " index",
           "corners are written v, v/vt, v//vn or v/vt/vn");
    if (index < 0) index += static_cast<long long>(latest) + 1;
    if (index < 1 || index > static_cast<long long>(kMaxScanElements))
      fail(std::string("face: ") + what + " index " + std::string(word) + " is out of range",
           "export the scan again: indices count from 1");
    return static_cast<uint32_t>(index - 1);
  }

  Corner read_corner(std::string_view word) const {
    Corner corner;
    const size_t slash = word.find('/');
    corner.position = read_index(word.substr(0, slash), positions_.size(), "vertex");
    if (slash == std::string_view::npos) return corner;
    const std::string_view tail = word.substr(slash + 1);
    const std::string_view uv = tail.substr(0, tail.find('/'));
    if (!uv.empty()) corner.uv = read_index(uv, scan_.uvs.size(), "UV");
    return corner;
  }

  void read_face(std::string_view line) {
    check_room(scan_.corners.size(), "corners");
    if (!group_known_) {
      group_ =
          index_of(group_name_.empty() ? "default" : group_name_, scan_.groups, group_indices_, "groups");
      group_known_ = true;
    }
    if (material_ == kNoMaterial)
      material_ = index_of("default", material_names_, material_indices_, "materials");
    begin_face(scan_, material_, group_);
    face_lines_.push_back(static_cast<uint32_t>(lines_.number()));
    const size_t first = scan_.corners.size();
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line))
      scan_.corners.push_back(read_corner(word));
    const size_t count = scan_.corners.size() - first;
    if (count < 3)
      fail("face with " + std::to_string(count) + (count == 1 ? " corner" : " corners"),
           "a face needs 3 corners: remove the line");
    if (count > kMaxFaceCorners)
      fail("face with " + std::to_string(count) + " corners",
           "split it: a face may have " + std::to_string(kMaxFaceCorners));
    for (size_t i = first; i < scan_.corners.size(); ++i)
      if ((scan_.corners[i].uv == Corner::kNoUv) != (scan_.corners[first].uv == Corner::kNoUv))
        fail("face with a UV at some corners only", "unwrap it whole or not at all");
  }

  /// At the end of the file, since a face may come before its vertices.
  void check_indices() const {
    for (size_t f = 0; f < scan_.face_count(); ++f)
      for (uint32_t c = scan_.face_begin[f]; c < scan_.face_begin[f + 1]; ++c) {
        const Corner& corner = scan_.corners[c];
        const bool bad_position = corner.position >= positions_.size();
        if (!bad_position && (corner.uv == Corner::kNoUv || corner.uv < scan_.uvs.size())) continue;
        throw InputError(file_.string(), "line " + std::to_string(face_lines_[f]),
                         std::string("face: ") + (bad_position ? "vertex" : "UV") + " index " +
                             std::to_string((bad_position ? corner.position : corner.uv) + 1) +
                             " is out of range: the file has " +
                             std::to_string(bad_position ? positions_.size() : scan_.uvs.size()),
                         "the file may be cut off: export the scan again");
      }
  }

  size_t index_of(const std::string& name, std::vector<std::string>& names,
                  std::unordered_map<std::string, size_t>& indices, const char* what) const {
    const auto [found, is_new] = indices.emplace(name, names.size());
    if (is_new && names.size() >= kMaxScanNames)
      fail("more than " + std::to_string(kMaxScanNames) + " " + what, "join some of them");
    if (is_new) names.push_back(name);
    return found->second;
  }

  /// One name that may hold blanks, or several names.
  void read_materials(const std::string& names) {
    has_library_ = true;
    if (names.empty()) fail("mtllib without a file name", "name the .mtl file or remove the line");
    if (read_library(names)) return;
    std::vector<std::string> missing;
    size_t count = 0;
    std::string_view rest = names;
    for (std::string_view name = next_word(rest); !name.empty(); name = next_word(rest), ++count)
      if (!read_library(std::string(name))) missing.emplace_back(name);
    if (missing.size() == count) missing = {names};
    for (const std::string& name : missing) {
      lacks_library_ = true;
      const std::string nearest = files_.nearest_name(file_, name, {".mtl"});
      files_.add_missing(file_, lines_.place(), "material library '" + name + "' is not there",
                         "put it into " + file_.parent_path().string() + " or remove the line" +
                             (nearest.empty() ? "" : "; '" + nearest + "' is there: name it if it is meant"));
    }
  }

  bool read_library(const std::string& name) {
    const std::optional<std::filesystem::path> library = files_.file(file_, lines_.place(), name);
    if (!library) return false;
    for (auto& [key, material] : read_mtl(*library, files_, scan_.notes)) library_.emplace(key, material);
    return true;
  }

  void resolve_materials() {
    for (const std::string& name : material_names_) {
      const auto found = library_.find(name);
      if (found != library_.end()) {
        scan_.materials.push_back(found->second);
        continue;
      }
      scan_.materials.emplace_back().name = name;
      if (has_library_ && !lacks_library_ && name != "default")
        files_.add_missing(file_, "usemtl " + name, "no .mtl file of the scan has this material",
                           "correct the name or the mtllib line");
    }
  }

  static constexpr size_t kNoMaterial = static_cast<size_t>(-1);
  static constexpr Vec3f kNoColour{-1, -1, -1};

  std::filesystem::path file_;
  TextLines lines_;
  Scan scan_;
  ScanFiles files_;
  std::vector<Vec3d> positions_;
  std::vector<Vec3f> colours_;  // of positions, kNoColour for those without; may be shorter
  std::vector<uint32_t> face_lines_;
  std::vector<std::string> material_names_;
  std::unordered_map<std::string, size_t> material_indices_, group_indices_;
  std::map<std::string, ScanMaterial> library_;
  bool has_library_ = false, lacks_library_ = false;
  size_t material_ = kNoMaterial, group_ = 0;
  std::string group_name_;
  bool group_known_ = false;
};

}  // namespace

Scan read_obj(const std::filesystem::path& file) {
  const std::string text = read_file(file);
  return ObjReader(file, text).read();
}

}  // namespace ohb
