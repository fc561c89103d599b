#include "dataset/commands/scan_hand_over.h"

#include "dataset/model/atomic_file.h"
#include "dataset/model/image.h"

namespace ohb::commands {
namespace {

template <typename T>
void append(std::string& bytes, const std::vector<T>& values) {
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

std::string mesh_bytes(const Scan& scan) {
  static_assert(sizeof(Vec3f) == 12 && sizeof(Vec2f) == 8);
  std::vector<uint32_t> positions;
  std::vector<Vec2f> uvs;
  for (const Corner& corner : scan.corners) {
    positions.push_back(corner.position);
    uvs.push_back(corner.uv == Corner::kNoUv ? Vec2f{} : scan.uvs[corner.uv]);
  }
  std::string bytes;
  append(bytes, scan.positions);
  append(bytes, scan.face_begin);
  append(bytes, positions);
  append(bytes, uvs);
  append(bytes, scan.face_material);
  append(bytes, scan.face_group);
  return bytes;
}

/// A file that shows the picture; a new one where the picture is embedded or its view is not plain.
std::filesystem::path file_of(const ScanPicture& picture, const std::filesystem::path& folder,
                              size_t number) {
  if (picture.empty()) return {};
  if (!picture.embedded && picture.view.is_plain()) return picture.file;
  const std::filesystem::path stem = folder / ("picture_" + std::to_string(number));
  if (!picture.view.is_plain()) {
    const std::filesystem::path file = stem.string() + ".png";
    write_png(file, read_image(picture));
    return file;
  }
  const bool is_png = picture.embedded->rfind("\x89PNG", 0) == 0;
  const std::filesystem::path file = stem.string() + (is_png ? ".png" : ".jpg");
  write_file_atomically(file, *picture.embedded);
  return file;
}

}  // namespace

nlohmann::ordered_json hand_over_scan(const Scan& scan, const std::filesystem::path& folder) {
  make_folders(folder);
  nlohmann::ordered_json materials = nlohmann::ordered_json::array();
  for (const ScanMaterial& material : scan.materials) {
    const Vec3f c = material.diffuse_factor;
    materials.push_back({{"name", material.name},
                         {"picture", file_of(material.diffuse, folder, materials.size()).string()},
                         {"color", {c.x, c.y, c.z}}});
  }
  const std::filesystem::path file = folder / "mesh.bin";
  write_file_atomically(file, mesh_bytes(scan));
  return {{"file", file.string()},      {"positions", scan.positions.size()},
          {"faces", scan.face_count()}, {"corners", scan.corners.size()},
          {"materials", materials},     {"groups", scan.groups}};
}

}  // namespace ohb::commands
