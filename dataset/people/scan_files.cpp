#include "dataset/people/scan_files.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "dataset/model/atomic_file.h"
#include "dataset/model/json_text.h"

namespace ohb::people {
namespace fs = std::filesystem;
namespace {

void append(std::string& text, float value, int decimals) {
  char buffer[64];
  text.append(buffer,
              std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, decimals).ptr);
}

std::string obj_text(const std::string& name, const ScannedPerson& scan) {
  std::string text =
      "# " + name + ": one mesh, one atlas; centimetres, Y up, facing +Z\nmtllib " + name + ".mtl\n";
  for (const Vec3f& p : scan.positions_cm) {
    text += "v ";
    append(text, p.x, 3), text += ' ';
    append(text, p.y, 3), text += ' ';
    append(text, p.z, 3), text += '\n';
  }
  for (const Vec2f& uv : scan.uvs) {
    text += "vt ";
    append(text, uv.x, 6), text += ' ';
    append(text, uv.y, 6), text += '\n';
  }
  text += "o " + name + "\nusemtl atlas\n";
  for (size_t face = 0; face < scan.face_count(); ++face) {
    text += 'f';
    for (uint32_t c = scan.face_begin[face]; c < scan.face_begin[face + 1]; ++c)
      text += fmt::format(" {}/{}", scan.corners[c].position + 1, scan.corners[c].uv + 1);
    text += '\n';
  }
  return text;
}

void write_jpeg(const fs::path& file, const ByteImage& image) {
  OIIO::ImageSpec spec(image.width_px, image.height_px, 3, OIIO::TypeDesc::UINT8);
  spec.attribute("compression", "jpeg:93");
  spec.attribute("jpeg:subsampling", "4:4:4");
  spec.attribute("DateTime", "2020:01:01 00:00:00");
  OIIO::Filesystem::IOVecOutput bytes;
  const auto output = OIIO::ImageOutput::create("jpg");
  if (!output) throw std::logic_error("OpenImageIO has no JPEG writer");
  output->set_ioproxy(&bytes);
  if (!output->open(file.string(), spec) ||
      !output->write_image(OIIO::TypeDesc::UINT8, image.values.data()) || !output->close())
    throw std::logic_error("write_jpeg: " + output->geterror());
  write_file_atomically(file, std::string(bytes.buffer().begin(), bytes.buffer().end()));
}

float area_of(const ScannedPerson& scan, size_t face) {
  float area = 0;
  const uint32_t begin = scan.face_begin[face], end = scan.face_begin[face + 1];
  const auto at = [&](uint32_t c) { return scan.positions_cm[scan.corners[c].position]; };
  for (uint32_t c = begin + 1; c + 1 < end; ++c)
    area += .5f * length(cross(at(c) - at(begin), at(c + 1) - at(begin)));
  return area;
}

}  // namespace

void write_scan(const fs::path& folder, const std::string& person, const ScannedPerson& scan,
                const nlohmann::json& extra) {
  const std::string name = person + "_scan";
  write_file_atomically(folder / (name + ".obj"), obj_text(name, scan));
  write_file_atomically(folder / (name + ".mtl"),
                        "newmtl atlas\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd " + name + ".jpg\n");
  write_jpeg(folder / (name + ".jpg"), scan.picture);
  std::string labels;
  std::map<std::string, size_t> faces;
  std::map<std::string, double> areas;
  std::map<std::string, std::map<std::string, int>> parts;
  size_t triangles = 0;
  for (size_t face = 0; face < scan.face_count(); ++face) {
    labels += static_cast<char>('0' + scan.face_class[face]);
    labels += '\n';
    const std::string of = kClassNames[scan.face_class[face]];
    ++faces[of];
    areas[of] += static_cast<double>(area_of(scan, face));
    ++parts[of][scan.part_of_face[face]];
    triangles += scan.face_begin[face + 1] - scan.face_begin[face] - 2;
  }
  write_file_atomically(folder / (name + ".labels.txt"), labels);
  nlohmann::json json = {{"name", name},
                         {"units", "cm"},
                         {"classes", kClassNames},
                         {"labels", name + ".labels.txt"},
                         {"vertices", scan.positions_cm.size()},
                         {"faces", scan.face_count()},
                         {"triangles", triangles},
                         {"faces_of_class", faces},
                         {"hidden_faces_dropped", scan.unseen_faces},
                         {"atlas_px", scan.picture.width_px},
                         {"texels_per_cm", std::round(100.0 * static_cast<double>(scan.px_per_cm)) / 100}};
  for (const auto& [of, area] : areas) json["area_cm2_of_class"][of] = std::round(10 * area) / 10;
  for (const auto& [of, names] : parts)
    for (const auto& [part, count] : names) json["parts_of_class"][of].push_back(part);
  json.update(extra);
  write_file_atomically(folder / (name + ".json"), json_text(json, 1) + "\n");
}

}  // namespace ohb::people
