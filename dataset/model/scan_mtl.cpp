// Wavefront MTL: the statements that a human's materials need.
//   Kd                         diffuse colour, linear; only where there is no map_Kd (as Blender does)
//   map_Kd                     diffuse picture, sRGB
//   map_d                      cut-out, with -imfchan m, l or none
//   d, Tr                      opacity, and 1 - opacity (where there is no d); multiplies map_d
//   norm                       tangent-space normal map
//   map_Bump, map_bump, bump   a normal map if the picture is one; a grey height map is noted and not used
//
// Pictures take -s and -o (UV' = UV * s + o, as Blender does) and -clamp on.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/scan_readers.h"
#include "dataset/model/text_lines.h"

namespace ohb {
namespace {

struct MapStatement {
  std::string picture;
  std::string channel;  // of -imfchan
  PictureView view;
};

class MtlReader {
 public:
  MtlReader(const std::filesystem::path& file, std::string_view text, ScanFiles& files,
            std::vector<std::string>& notes)
      : file_(file), lines_(file, text), files_(files), notes_(notes) {}

  std::map<std::string, ScanMaterial> read() {
    while (lines_.next()) read_line(lines_.line());
    for (auto& [name, material] : materials_) {
      if (!material.diffuse.empty()) material.diffuse_factor = {1, 1, 1};
      if (material.opacity == 0 && !material.alpha.empty()) material.opacity = 1;  // Blender: map_d alone
      // Some programs write Tr as the opacity; Blender reads d alone.
      if (material.opacity == 0 && has_d_.count(name) == 0) {
        material.opacity = 1;
        notes_.push_back("material '" + name +
                         "': Tr 1 is taken as opaque, as in Blender; write d 0 if it is clear");
      }
      note_opacity(material);
    }
    return std::move(materials_);
  }

 private:
  [[noreturn]] void fail(const std::string& cause, const std::string& mend) const {
    throw InputError(file_.string(), lines_.place(), cause, mend);
  }

  void note_opacity(const ScanMaterial& material) {
    if (material.opacity >= 1) return;
    char text[128];
    std::snprintf(text, sizeof text, "' has an opacity of %.4g (d, Tr)%s", material.opacity,
                  material.opacity > 0 ? "" : ": it is not seen, in Blender neither");
    notes_.push_back("material '" + material.name + text);
  }

  void read_line(std::string_view line) {
    const std::string keyword(next_word(line));
    if (keyword == "newmtl") {
      start_material(lines_.name());
    } else if (keyword == "Kd") {
      current(keyword).diffuse_factor = read_colour(line);
    } else if (keyword == "map_Kd") {
      current(keyword).diffuse = find_picture(read_map(keyword, lines_.name()));
    } else if (keyword == "d" || keyword == "Tr") {
      read_opacity(keyword, line);
    } else if (keyword == "map_d") {
      read_alpha(lines_.name());
    } else if (keyword == "norm") {
      current(keyword).normal = find_picture(read_map(keyword, lines_.name()));
    } else if (keyword == "map_Bump" || keyword == "map_bump" || keyword == "bump") {
      read_bump(keyword, lines_.name());
    }
  }

  ScanPicture find_picture(const MapStatement& map) {
    ScanPicture picture = files_.picture(file_, lines_.place(), {map.picture});
    if (!picture.empty()) picture.view = map.view;
    return picture;
  }

  void start_material(std::string_view line) {
    name_ = std::string(trimmed(line));
    if (name_.empty()) fail("newmtl without a name", "name the material");
    if (materials_.count(name_)) fail("material '" + name_ + "' is there twice", "rename one of them");
    materials_[name_].name = name_;
  }

  ScanMaterial& current(const std::string& keyword) {
    if (name_.empty()) fail(keyword + " before any newmtl", "the file may be cut off: export it again");
    return materials_[name_];
  }

  Vec3f read_colour(std::string_view line) const {
    float rgb[3] = {0, 0, 0};
    for (int i = 0; i < 3; ++i) {
      const std::string_view word = next_word(line);
      if (word.empty() && i > 0) {
        rgb[i] = rgb[0];  // one number stands for all three
      } else if (!parse_float(word, rgb[i]) || !std::isfinite(rgb[i]) || rgb[i] < 0) {
        fail("Kd: '" + std::string(word.substr(0, 40)) + "' is no colour value",
             "write three numbers from 0 to 1");
      }
    }
    return {rgb[0], rgb[1], rgb[2]};
  }

  /// "d .5", "d -halo .5", "Tr .5".
  void read_opacity(const std::string& keyword, std::string_view line) {
    std::string_view word = next_word(line);
    if (word == "-halo") word = next_word(line);
    float value = 0;
    if (!parse_float(word, value) || !std::isfinite(value))
      fail(keyword + ": '" + std::string(word.substr(0, 40)) + "' is no opacity",
           "write a number from 0 to 1");
    value = std::clamp(value, 0.0f, 1.0f);
    ScanMaterial& material = current(keyword);
    if (keyword == "d") has_d_.insert(material.name);
    if (keyword == "d" || has_d_.count(material.name) == 0)
      material.opacity = keyword == "d" ? value : 1 - value;
  }

  void read_alpha(std::string_view line) {
    const MapStatement map = read_map("map_d", line);
    if (!map.channel.empty() && map.channel != "m" && map.channel != "l")
      fail("map_d takes the channel '" + map.channel + "'",
           "put the cut-out into the alpha channel and write -imfchan m");
    current("map_d").alpha = find_picture(map);
  }

  void read_bump(const std::string& keyword, std::string_view line) {
    ScanMaterial& material = current(keyword);
    const ScanPicture picture = find_picture(read_map(keyword, line));
    if (picture.empty()) return;
    if (!is_normal_map(picture)) {
      notes_.push_back(file_.filename().string() + ": " + lines_.place() + ": " +
                       picture.file.filename().string() + " is a grey height map, which is not used");
    } else if (material.normal.empty()) {  // `norm` goes first
      material.normal = picture;
    }
  }

  /// The options, then the picture's name, which may hold blanks.
  MapStatement read_map(const std::string& keyword, std::string_view line) const {
    MapStatement map;
    for (line = trimmed(line); !line.empty() && line.front() == '-'; line = trimmed(line)) {
      std::string_view rest = line;
      const std::string option(next_word(rest));
      const int least = least_arguments(option);
      if (least < 0) break;  // a file name that begins with '-'
      read_option(option, least, rest, map);
      line = rest;
    }
    map.picture = std::string(line);
    if (map.picture.empty()) fail(keyword + " without a picture", "name the picture or remove the line");
    return map;
  }

  /// Words that must follow the option; -1 for what is no option.
  static int least_arguments(const std::string& option) {
    if (option == "-mm") return 2;
    for (const char* known : {"-o", "-s", "-t", "-blendu", "-blendv", "-boost", "-cc", "-clamp", "-texres",
                              "-imfchan", "-bm", "-type"})
      if (option == known) return 1;
    return -1;
  }

  void read_option(const std::string& option, int least, std::string_view& rest, MapStatement& map) const {
    const bool is_vector = option == "-o" || option == "-s" || option == "-t";
    for (int i = 0; i < (is_vector ? 3 : least); ++i) {
      std::string_view after = rest;
      const std::string_view word = next_word(after);
      float value = 0;
      const bool is_number = parse_float(word, value);
      if (is_vector && i > 0 && !is_number) break;
      if (word.empty() || (is_vector && (!is_number || !std::isfinite(value))))
        fail("option " + option + " without its value", "correct or remove the option");
      if (option == "-o" && i < 2) (i == 0 ? map.view.u0 : map.view.v0) = value;
      if (option == "-s" && i < 2) (i == 0 ? map.view.uu : map.view.vv) = value;
      if (option == "-clamp" && word == "on") map.view.wrap_u = map.view.wrap_v = Wrap::kClamp;
      if (option == "-imfchan") map.channel = std::string(word);
      rest = after;
    }
  }

  std::filesystem::path file_;
  TextLines lines_;
  ScanFiles& files_;
  std::vector<std::string>& notes_;
  std::map<std::string, ScanMaterial> materials_;
  std::set<std::string> has_d_;
  std::string name_;
};

}  // namespace

std::map<std::string, ScanMaterial> read_mtl(const std::filesystem::path& file, ScanFiles& files,
                                             std::vector<std::string>& notes) {
  const std::string text = read_file(file);
  return MtlReader(file, text, files, notes).read();
}

}  // namespace ohb
