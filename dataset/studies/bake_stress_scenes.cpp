#include "dataset/studies/bake_stress_scenes.h"

#include <cmath>
#include <functional>
#include <map>

#include "dataset/model/colour.h"
#include "dataset/model/error.h"

namespace ohb::studies {
namespace fs = std::filesystem;
namespace {

constexpr float kEdge_cm = 100;
constexpr float kWave = 2 * 3.14159265f / kEdge_cm;
constexpr int kLowCells = 8, kSourceCells = 120, kPicture_px = 256, kMap_px = 128;

float wave_z(float x, float y) {
  return std::sin(kWave * x) * std::cos(kWave * y);
}

/// A picture of a function of (x, y) in cm, sRGB-encoded unless it is a mask.
ScanPicture painted(const fs::path& file, int size_px, const std::function<Vec3f(float, float)>& colour,
                    bool is_mask) {
  Image image(size_px, size_px, is_mask ? 1 : 3);
  for (int row = 0; row < size_px; ++row)
    for (int column = 0; column < size_px; ++column) {
      const float x = kEdge_cm * (static_cast<float>(column) + 0.5f) / static_cast<float>(size_px);
      const float y = kEdge_cm * (1 - (static_cast<float>(row) + 0.5f) / static_cast<float>(size_px));
      const Vec3f value = colour(x, y);
      for (int c = 0; c < image.channels; ++c)
        image.pixel(column, row)[c] = is_mask ? value[c] : linear_to_srgb(value[c]);
    }
  write_png(file, image, 16);
  return {file, nullptr};
}

ScanPicture wave_picture(const fs::path& file) {
  return painted(
      file, kPicture_px, [](float x, float y) { return sheet_truth(x, y).albedo; }, false);
}

/// A grid over [0, 1 m]^2 facing +Z of triangles with UVs of their own, UV = (x, y) / 1 m.
Scan sheet(int cells, const std::function<float(float, float)>& z) {
  Scan scan;
  scan.groups = {"all"};
  scan.face_begin = {0};
  const float step = kEdge_cm / static_cast<float>(cells);
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) {
      const float x = step * static_cast<float>(i), y = step * static_cast<float>(j);
      scan.positions.push_back({x, y, z(x, y)});
    }
  const auto index = [&](int i, int j) { return static_cast<uint32_t>(j * (cells + 1) + i); };
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i)
      for (int half = 0; half < 2; ++half) {
        const uint32_t corners[3] = {index(i, j), half ? index(i + 1, j + 1) : index(i + 1, j),
                                     half ? index(i, j + 1) : index(i + 1, j + 1)};
        for (uint32_t corner : corners) {
          scan.corners.push_back({corner, static_cast<uint32_t>(scan.uvs.size())});
          const Vec3f p = scan.positions[corner];
          scan.uvs.push_back({p.x / kEdge_cm, p.y / kEdge_cm});
        }
        scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
      }
  scan.face_material.assign(scan.face_count(), 0);
  scan.face_group.assign(scan.face_count(), 0);
  scan.materials.resize(1);
  scan.materials[0].name = "sheet";
  return scan;
}

/// Adds another scan's faces, as further materials.
void append(Scan& scan, const Scan& other) {
  const auto positions = static_cast<uint32_t>(scan.positions.size());
  const auto uvs = static_cast<uint32_t>(scan.uvs.size());
  const auto materials = static_cast<uint16_t>(scan.materials.size());
  scan.positions.insert(scan.positions.end(), other.positions.begin(), other.positions.end());
  scan.uvs.insert(scan.uvs.end(), other.uvs.begin(), other.uvs.end());
  scan.materials.insert(scan.materials.end(), other.materials.begin(), other.materials.end());
  for (size_t f = 0; f < other.face_count(); ++f) {
    for (uint32_t c = other.face_begin[f]; c < other.face_begin[f + 1]; ++c)
      scan.corners.push_back({other.corners[c].position + positions, other.corners[c].uv + uvs});
    scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
    scan.face_material.push_back(static_cast<uint16_t>(other.face_material[f] + materials));
    scan.face_group.push_back(0);
  }
}

/// The UVs of face f of a sheet, whose corners have their own.
Vec2f* uvs_of(Scan& scan, size_t face) {
  return &scan.uvs[3 * face];
}
int column_of(size_t face) {
  return static_cast<int>(face / 2) % kLowCells;
}
int row_of(size_t face) {
  return static_cast<int>(face / 2) / kLowCells;
}

/// Whether element i of n is among a share of them, spread evenly.
bool is_among(size_t i, double share) {
  return std::floor(static_cast<double>(i + 1) * share + 1e-9) >
         std::floor(static_cast<double>(i) * share + 1e-9);
}

void turn_face(Scan& scan, size_t face) {
  std::swap(scan.corners[3 * face + 1], scan.corners[3 * face + 2]);
}

void mirror_columns(BakeStressScene& scene, double share) {
  const double block = std::round(share * kLowCells) / kLowCells;
  for (size_t f = 0; f < scene.low.face_count(); ++f)
    for (int c = 0; c < 3; ++c) {
      Vec2f& uv = uvs_of(scene.low, f)[c];
      if (column_of(f) < share * kLowCells) uv.x = static_cast<float>(block - uv.x);
    }
}

/// Moves the right half over the left one by that share of the map.
void overlap_halves(BakeStressScene& scene, double share) {
  for (size_t f = 0; f < scene.low.face_count(); ++f)
    if (column_of(f) >= kLowCells / 2)
      for (int c = 0; c < 3; ++c) uvs_of(scene.low, f)[c].x -= static_cast<float>(share);
}

/// Each cell a chart of its own, so many texels wide and high.
void shrink_charts(BakeStressScene& scene, double width_texels, double height_texels) {
  const float slot = 1.0f / kLowCells;
  for (size_t f = 0; f < scene.low.face_count(); ++f)
    for (int c = 0; c < 3; ++c) {
      Vec2f& uv = uvs_of(scene.low, f)[c];
      const Vec2f corner{slot * static_cast<float>(column_of(f)), slot * static_cast<float>(row_of(f))};
      const Vec2f within = {(uv.x - corner.x) / slot, (uv.y - corner.y) / slot};
      uv = {corner.x + 0.013f + within.x * static_cast<float>(width_texels / kMap_px),
            corner.y + 0.013f + within.y * static_cast<float>(height_texels / kMap_px)};
    }
}

void flip_uvs(BakeStressScene& scene, double share) {
  for (size_t f = 0; f < scene.low.face_count(); ++f)
    if (is_among(f, share)) std::swap(uvs_of(scene.low, f)[1], uvs_of(scene.low, f)[2]);
}

void collapse_uvs(BakeStressScene& scene, double share) {
  for (size_t f = 0; f < scene.low.face_count(); ++f)
    if (is_among(f, share)) uvs_of(scene.low, f)[1] = uvs_of(scene.low, f)[2] = uvs_of(scene.low, f)[0];
}

/// Upright triangles on inner edges, which then have three; their UVs lie in a strip that the sheet leaves.
void add_fins(BakeStressScene& scene, double count) {
  for (Vec2f& uv : scene.low.uvs) uv.y *= 0.9f;
  Scan fins;
  for (size_t f = 0; f < static_cast<size_t>(count); ++f) {
    const Corner a = scene.low.corners[6 * f], b = scene.low.corners[6 * f + 2];  // a cell's diagonal
    const Vec3f middle = 0.5f * (scene.low.positions[a.position] + scene.low.positions[b.position]);
    scene.low.positions.push_back(middle + Vec3f{0, 0, 4});
    const float u = static_cast<float>(f) / 64;
    for (const Vec2f& uv : {Vec2f{u, 0.95f}, Vec2f{u + 0.01f, 0.95f}, Vec2f{u, 0.96f}})
      scene.low.uvs.push_back(uv);
    const auto uv = static_cast<uint32_t>(scene.low.uvs.size());
    const auto tip = static_cast<uint32_t>(scene.low.positions.size() - 1);
    scene.low.corners.insert(scene.low.corners.end(),
                             {{a.position, uv - 3}, {b.position, uv - 2}, {tip, uv - 1}});
    scene.low.face_begin.push_back(static_cast<uint32_t>(scene.low.corners.size()));
    scene.low.face_material.push_back(0);
    scene.low.face_group.push_back(0);
  }
  scene.options.source.max_missed_share = 1;  // the source has no fins
}

/// A second sheet of another colour that far below the first; the low one follows the wave at its corners.
void add_inner(BakeStressScene& scene, double gap_cm) {
  for (Vec3f& p : scene.low.positions) p.z = wave_z(p.x, p.y);
  Scan inner =
      sheet(kSourceCells, [&](float x, float y) { return wave_z(x, y) - static_cast<float>(gap_cm); });
  inner.materials[0].diffuse_factor = {1, 0, 0};
  append(scene.source, inner);
}

void turn_source_faces(BakeStressScene& scene, double share) {
  for (size_t f = 0; f < scene.source.face_count(); ++f)
    if (is_among(f, share)) turn_face(scene.source, f);
}

void move_source(BakeStressScene& scene, double distance_cm) {
  for (Vec3f& p : scene.source.positions) p.z += static_cast<float>(distance_cm);
}

void move_all(BakeStressScene& scene, double distance_cm) {
  scene.place = {static_cast<float>(distance_cm), 0, 0};
  for (Scan* scan : {&scene.low, &scene.source})
    for (Vec3f& p : scan->positions) p = p + scene.place;
}

/// No source: the sheet's own picture and a mask of that many times its size.
void mask_of_size(BakeStressScene& scene, double times, const fs::path& scratch) {
  scene.low.materials[0].diffuse = wave_picture(scratch / "own.png");
  scene.low.materials[0].alpha = painted(
      scratch / "mask.png", static_cast<int>(std::lround(times * kPicture_px)),
      [](float x, float y) {
        const float alpha = sheet_truth(x, y).alpha;
        return Vec3f{alpha, alpha, alpha};
      },
      true);
  scene.options.source.scan = nullptr;
  scene.has_alpha = true;
}

using Change = std::function<void(BakeStressScene&, double)>;

/// What makes the plain sheet the scene of that name; empty for "mask size", which needs a folder
/// (mask_of_size). Throws InputError for another name.
Change change_of(const std::string& name) {
  static const std::map<std::string, Change> changes = {
      {"mirrored", mirror_columns},
      {"overlap", overlap_halves},
      {"overlap allowed",
       [](BakeStressScene& s, double share) {
         overlap_halves(s, share);
         s.options.source.max_overlap_share = 1;
       }},
      {"slivers", [](BakeStressScene& s, double width) { shrink_charts(s, width, 12); }},
      {"small charts", [](BakeStressScene& s, double edge) { shrink_charts(s, edge, edge); }},
      {"flipped", flip_uvs},
      {"zero area", collapse_uvs},
      {"fins", add_fins},
      {"nested", add_inner},
      {"inside out", turn_source_faces},
      {"far source", move_source},
      {"far away", move_all},
      {"mask size", nullptr}};
  const auto change = changes.find(name);
  if (change == changes.end()) {
    std::string names;
    for (const auto& [known, unused] : changes) names += (names.empty() ? "" : ", ") + known;
    throw InputError("", "scene '" + name + "'", "is not known", "use one of: " + names);
  }
  return change->second;
}

}  // namespace

SheetTruth sheet_truth(float x, float y) {
  SheetTruth truth;
  const float slope_x = kWave * std::cos(kWave * x) * std::cos(kWave * y);
  const float slope_y = -kWave * std::sin(kWave * x) * std::sin(kWave * y);
  truth.normal = normalised({-slope_x, -slope_y, 1});
  truth.albedo = {0.5f + 0.4f * std::sin(kWave * x), 0.5f + 0.4f * std::cos(kWave * y), 0.3f};
  truth.z = wave_z(x, y);
  truth.alpha = 0.6f + 0.4f * std::sin(2 * kWave * x) * std::sin(2 * kWave * y);
  return truth;
}

void make_bake_stress_scene(const std::string& name, double at, const fs::path& scratch,
                            BakeStressScene& scene) {
  const Change change = change_of(name);
  scene.low = sheet(kLowCells, [](float, float) { return 0.0f; });
  scene.low.file = "low.obj";
  scene.source = sheet(kSourceCells, wave_z);
  scene.source.file = "source.obj";
  scene.source.materials[0].diffuse = wave_picture(scratch / "source.png");
  scene.measured_faces = scene.low.face_count();
  scene.options.size_px = kMap_px;
  scene.options.source.scan = &scene.source;
  if (change)
    change(scene, at);
  else
    mask_of_size(scene, at, scratch);
  scene.regions = {std::vector<uint8_t>(scene.low.face_count(), kFabric), std::string(64, '0')};
}

}  // namespace ohb::studies
