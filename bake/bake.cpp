#include "bake/bake.h"

#include <nlohmann/json.hpp>

#include "dataset/model/atomic_file.h"
#include "dataset/model/model_files.h"
#include "dataset/model/progress.h"

namespace ohb {
namespace {

CanonicalMesh mesh_of(const Scan& scan, const Regions& regions, const BakeOptions& options,
                      BakeReport& report) {
  CanonicalMesh mesh = canonical_mesh(scan, regions, options.unit_cm);
  mesh.model.name = options.name;
  report.scan = mesh.model.source_file;
  report.scan_sha256 = mesh.model.source_sha256;
  report.unit_cm = mesh.model.source_unit_cm;
  report.unit_reason = options.unit_reason;
  const Bounds bounds = bounds_of(mesh.model.positions_cm);
  for (int i = 0; i < 3; ++i) {
    report.shift_cm[i] = mesh.model.source_shift_cm[i];
    report.size_cm[i] = bounds.high[i] - bounds.low[i];
  }
  report.triangles = mesh.model.triangles.size();
  report.positions = mesh.model.positions_cm.size();
  return mesh;
}

std::vector<std::string> folders_of(const CanonicalMesh& mesh) {
  std::vector<std::string> names;
  for (const TextureSet& set : mesh.model.sets) names.push_back(set.name);
  return texture_set_folders(names);
}

}  // namespace

BakeReport bake_to_folder(const Scan& scan, const Regions& regions, const MaterialTable& table,
                          const BakeOptions& options, const std::filesystem::path& folder) {
  BakeReport report;
  const CanonicalMesh mesh = mesh_of(scan, regions, options, report);
  const std::vector<std::string> folders = folders_of(mesh);
  std::vector<TextureSetEntry> entries;
  Progress progress("baking " + options.name, folders.size(), options.quiet);
  for (size_t i = 0; i < folders.size(); ++i) {
    SetReport set_report;
    set_report.folder = folders[i];
    TextureSet set = bake_texture_set(mesh, scan, static_cast<uint16_t>(i), table, options, set_report);
    entries.push_back(write_texture_set(folder, folders[i], std::move(set)));
    report.sets.push_back(std::move(set_report));
    progress.add();
  }
  write_model_mesh(folder, mesh.model, entries);
  write_file_atomically(folder / "report.json", to_json(report).dump(2) + "\n");
  return report;
}

Model bake(const Scan& scan, const Regions& regions, const MaterialTable& table, const BakeOptions& options,
           BakeReport* report) {
  BakeReport own;
  BakeReport& out = report ? *report : own;
  CanonicalMesh mesh = mesh_of(scan, regions, options, out);
  const std::vector<std::string> folders = folders_of(mesh);
  for (size_t i = 0; i < mesh.model.sets.size(); ++i) {
    SetReport set_report;
    set_report.folder = folders[i];
    mesh.model.sets[i] = bake_texture_set(mesh, scan, static_cast<uint16_t>(i), table, options, set_report);
    out.sets.push_back(std::move(set_report));
  }
  return std::move(mesh.model);
}

}  // namespace ohb
