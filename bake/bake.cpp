#include "bake/bake.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "bake/jobs.h"
#include "bake/texture_set_bake.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"
#include "dataset/model/model_files.h"
#include "dataset/model/progress.h"

namespace ohb::bake {
namespace {

void report_mesh(const Scan& scan, const CanonicalMesh& mesh, BakeReport& report) {
  report.scan = mesh.model.source_file;
  report.scan_sha256 = mesh.model.source_sha256;
  report.unit_cm = mesh.model.source_unit_cm;
  const Bounds bounds = bounds_of(mesh.model.positions_cm);
  const Vec3d offset = scan.removed_offset.value_or(Vec3d{});
  const double removed[3] = {offset.x, offset.y, offset.z};
  for (int i = 0; i < 3; ++i) {
    report.shift_cm[i] = mesh.model.source_shift_cm[i] - mesh.model.source_unit_cm * removed[i];
    report.size_cm[i] = bounds.high[i] - bounds.low[i];
  }
  report.triangles = mesh.model.triangles.size();
  report.repeated_faces = mesh.repeated_faces;
  report.positions = mesh.model.positions_cm.size();
}

std::vector<std::string> folders_of(const CanonicalMesh& mesh) {
  std::vector<std::string> names;
  for (const TextureSet& set : mesh.model.sets) names.push_back(set.name);
  return texture_set_folders(names);
}

double diagonal_cm(const Bounds& bounds) {
  return length(bounds.high - bounds.low);
}

/// Refuses a source that cannot be of the same subject: another size, or elsewhere.
void check_place(const BakeSource& source, const Bounds& low, const Bounds& high, double reach_cm) {
  const double ratio = diagonal_cm(high) / diagonal_cm(low);
  const auto refuse = [&](const std::string& cause) {
    throw InputError(source.scan->file.string(), "", cause,
                     "export both from one scene, or state the source's unit with --source-unit");
  };
  constexpr double kMostRatio = 3;
  if (!(ratio < kMostRatio && ratio > 1 / kMostRatio))
    refuse("is " + std::to_string(ratio) + " times as large as the scan");
  double apart = 0;
  for (int i = 0; i < 3; ++i)
    apart = std::max({apart, double(high.low[i]) - low.high[i], double(low.low[i]) - high.high[i]});
  if (apart > reach_cm) refuse("lies " + std::to_string(apart) + " cm away from the scan");
}

/// What was taken off the positions of a far-away scan, in cm.
Vec3d removed_cm(const Scan& scan, double unit_cm) {
  const Vec3d offset = scan.removed_offset.value_or(Vec3d{});
  return {unit_cm * offset.x, unit_cm * offset.y, unit_cm * offset.z};
}

/// What a second scan's positions lack to lie where the first's do.
Vec3f between_cm(const Vec3d& second, const Vec3d& first) {
  return {static_cast<float>(second.x - first.x), static_cast<float>(second.y - first.y),
          static_cast<float>(second.z - first.z)};
}

/// The cage's points less the scan's, in cm, one a position of the mesh.
std::vector<Vec3f> cage_offsets(const CanonicalMesh& mesh, const Scan& scan, const Scan& cage) {
  bool is_same = cage.face_begin == scan.face_begin && cage.positions.size() == scan.positions.size();
  for (size_t c = 0; is_same && c < scan.corners.size(); ++c)
    is_same = cage.corners[c].position == scan.corners[c].position;
  if (!is_same)
    throw InputError(cage.file.string(), "", "has other faces than " + scan.file.filename().string(),
                     "a cage is the scan itself with its points moved outwards");
  std::vector<Vec3f> offsets(mesh.model.positions_cm.size());
  const std::vector<ScanTriangle>& triangles = mesh.triangles;
  const float unit = static_cast<float>(mesh.model.source_unit_cm);
  const Vec3f between =
      between_cm(removed_cm(cage, mesh.model.source_unit_cm), removed_cm(scan, mesh.model.source_unit_cm));
  for (size_t t = 0; t < triangles.size(); ++t)
    for (int c = 0; c < 3; ++c) {
      const uint32_t p = scan.corners[triangles[t].corner[c]].position;
      offsets[mesh.model.triangles[t].position[c]] = unit * (cage.positions[p] - scan.positions[p]) + between;
    }
  return offsets;
}

/// Null without a source.
std::unique_ptr<SourceBake> source_of(const CanonicalMesh& mesh, const MeshFrames& frames, const Scan& scan,
                                      const BakeOptions& options, BakeReport& report) {
  const BakeSource& from = options.source;
  if (!from.scan) return nullptr;
  const Vec3f shift_cm = mesh.model.source_shift_cm + between_cm(removed_cm(*from.scan, from.unit_cm),
                                                                 removed_cm(scan, mesh.model.source_unit_cm));
  const auto surface = std::make_shared<const SourceSurface>(*from.scan, from.unit_cm, shift_cm, from.green);
  const Bounds bounds = bounds_of(mesh.model.positions_cm);
  const double reach_cm = from.reach_cm > 0 ? from.reach_cm : kReachShare * diagonal_cm(bounds);
  check_place(from, bounds, surface->bounds(), reach_cm);
  auto source = std::make_unique<SourceBake>();
  source->surface = surface;
  source->frames = &frames;
  source->outward_cm = source->inward_cm = static_cast<float>(reach_cm);
  source->wants_object_normals = from.wants_object_normals;
  if (from.cage) source->cage_offset = cage_offsets(mesh, scan, *from.cage);
  report.source = from.scan->file.filename().string();
  report.source_sha256 = from.sha256;
  report.source_triangles = surface->triangle_count();
  report.source_unit_cm = from.unit_cm;
  report.outward_cm = from.cage ? 0 : reach_cm;
  report.inward_cm = reach_cm;
  return source;
}

/// Makes the maps of kMapKinds and gives each to `use`, empty ones where the set has none.
Jobs map_jobs(SetBake& set, const std::function<void(const MapKind&, Image)>& use) {
  const auto kind_of = [](Image TextureSet::*image) -> const MapKind& {
    return *std::find_if(kMapKinds.begin(), kMapKinds.end(),
                         [&](const MapKind& kind) { return kind.image == image; });
  };
  return {
      [=, &set] { use(kind_of(&TextureSet::displacement), set.take_displacement()); },
      [=, &set] { use(kind_of(&TextureSet::albedo), set.take_albedo()); },
      [=, &set] { use(kind_of(&TextureSet::normal), set.take_normal()); },
      [=, &set] {
        auto maps = set.take_class_maps();
        for (size_t i = 0; i < maps.size(); ++i) use(kind_of(kMaterialMaps[i].texels), std::move(maps[i]));
      },
      [=, &set] { use(kind_of(&TextureSet::alpha), set.take_alpha()); },
  };
}

/// Maps beside those of kMapKinds, which model.xml does not name: half, of one or three channels.
void write_extra_map(const std::filesystem::path& file, const std::string& name, Image image) {
  if (image.values.empty()) return;
  std::vector<ExrPart> parts(1);
  parts[0].name = name;
  parts[0].channels =
      image.channels == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"};
  parts[0].image = std::move(image);
  write_exr(file, parts, {{"compression", "rle"}});
}

/// All files of a set's folder; gives what model.xml says of it.
TextureSetEntry write_set(SetBake& set, const std::filesystem::path& folder, TextureSetEntry entry,
                          bool wants_mips) {
  const std::filesystem::path maps = folder / "maps" / entry.folder;
  std::array<bool, kMapKinds.size()> is_named{};
  const auto write = [&](const MapKind& kind, Image image) {
    std::vector<Image> mips;
    if (wants_mips && !image.values.empty()) mips = set.mips_of(image, kind);
    is_named[&kind - kMapKinds.data()] =
        write_texture_map(folder, kind, std::move(image), entry, std::move(mips));
  };
  make_folders(maps);
  // The height and displacement of a source first: memory that the larger maps' levels then have.
  Jobs jobs = map_jobs(set, write);
  jobs.insert(jobs.begin(), [&] {
    if (const ByteImage debug = set.debug(); !debug.values.empty()) write_png(maps / "debug.png", debug);
    write_extra_map(maps / "height.exr", "height", set.take_height());
  });
  jobs.push_back(
      [&] { write_extra_map(maps / "normal_object.exr", "normal_object", set.take_object_normal()); });
  jobs.push_back([&] { write_png(maps / "valid.png", set.valid()); });
  // Maps of 8192 x 8192 from a source leave room in 4 GiB for the levels of one.
  constexpr size_t kMostTexelsInPairs = size_t{1} << 25;
  const bool are_large = static_cast<size_t>(set.width_px()) * set.height_px() > kMostTexelsInPairs;
  // With two at a time a map is written while the next is made, and few are in memory.
  run_jobs(jobs, wants_mips && are_large ? 1 : 2);
  for (size_t i = 0; i < kMapKinds.size(); ++i)
    if (is_named[i]) entry.maps.push_back(kMapKinds[i].name);
  return entry;
}

/// As TextureSet::valid.
Image image_of_valid(const ByteImage& bytes) {
  Image image(bytes.width_px, bytes.height_px, bytes.channels);
  std::transform(bytes.values.begin(), bytes.values.end(), image.values.begin(),
                 [](uint8_t value) { return value == 255 ? 1.0f : 0.5f; });
  return image;
}

/// Gives each texture set of the scan's mesh to `take`, one after the other so that few maps are in memory at
/// once.
void bake_sets(const Scan& scan, CanonicalMesh& mesh, const MaterialTable& table, const BakeOptions& options,
               BakeReport& report,
               const std::function<void(Model& model, size_t set_index, SetBake& set)>& take) {
  mesh.model.name = options.name;
  report_mesh(scan, mesh, report);
  report.unit_reason = options.unit_reason;
  MeshFrames frames;
  std::unique_ptr<SourceBake> source;
  run_side_by_side({[&] { frames = frames_of(mesh.model); },
                    [&] { source = source_of(mesh, frames, scan, options, report); }});
  const BakeInputs inputs{mesh, scan, table, options, frames, source.get()};
  const std::vector<std::string> folders = folders_of(mesh);
  report.sets.resize(folders.size());
  Progress progress("baking " + options.name, folders.size(), options.quiet);
  for (size_t i = 0; i < folders.size(); ++i) {
    report.sets[i].folder = folders[i];
    SetBake set(inputs, static_cast<uint16_t>(i), report.sets[i]);
    take(mesh.model, i, set);
    progress.add();
  }
}

}  // namespace

BakeReport bake_to_folder(const Scan& scan, CanonicalMesh mesh, const MaterialTable& table,
                          const BakeOptions& options, const std::filesystem::path& folder) {
  BakeReport report;
  std::vector<TextureSetEntry> entries;
  const auto write = [&](Model& model, size_t i, SetBake& set) {
    entries.push_back(write_set(
        set, folder, {model.sets[i].name, report.sets[i].folder, set.width_px(), set.height_px(), {}},
        options.wants_mips));
  };
  bake_sets(scan, mesh, table, options, report, write);
  write_model_mesh(folder, mesh.model, entries);
  write_file_atomically(folder / "report.json", json_text(to_json(report), 2) + "\n");
  return report;
}

Model bake_model(const Scan& scan, const Regions& regions, const MaterialTable& table,
                 const BakeOptions& options, BakeReport* report) {
  BakeReport own;
  CanonicalMesh mesh = canonical_mesh(scan, regions, options.unit_cm);
  const auto keep = [](Model& model, size_t i, SetBake& set) {
    TextureSet& maps = model.sets[i];
    run_jobs(map_jobs(set, [&](const MapKind& kind, Image image) { maps.*kind.image = std::move(image); }),
             2);
    maps.valid = image_of_valid(set.valid());
  };
  bake_sets(scan, mesh, table, options, report ? *report : own, keep);
  return std::move(mesh.model);
}

}  // namespace ohb::bake
