#include "dataset/commands/bake_scan.h"

#include <nlohmann/json.hpp>

#include <algorithm>

#include "dataset/commands/normal_convention.h"
#include "dataset/commands/picture_files.h"
#include "dataset/commands/uv_layout.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/data_files.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"
#include "dataset/model/mesh_topology.h"
#include "dataset/model/model_files.h"
#include "dataset/model/scan_unit.h"

namespace ohb::commands {
namespace fs = std::filesystem;
namespace {

Regions regions_of_scan(const BakeJob& job) {
  Regions regions = read_regions(job.regions);
  if (regions.scan_sha256 != sha256_of_file(job.scan))
    throw InputError(
        job.regions.string(), "",
        "was made from another scan than " + job.scan.filename().string() + " (the hash of the file differs)",
        "run `label` on this scan");
  return regions;
}

surface::GreenChannel green_of(const Scan& scan, const std::vector<ScanTriangle>& triangles,
                               const MeshTopology& topology, const std::vector<uint32_t>& chart_of_face,
                               uint16_t material) {
  ImageFileInfo info;
  Image image = read_image(scan.materials[material].normal, &info);
  if (image.channels < 3) return surface::GreenChannel::kUp;  // the bake refuses it
  if (info.is_float)
    for (float& value : image.values) value = 0.5f + 0.5f * value;
  const UvRaster raster =
      rasterise_uvs(scan, triangles, topology, material, {image.width_px, image.height_px});
  std::vector<uint32_t> region(static_cast<size_t>(image.width_px) * image.height_px, kNoRegion);
  for (size_t i = 0; i < raster.face.size(); ++i)
    if (raster.face[i] != kNoFace) region[i] = chart_of_face[raster.face[i]];
  switch (detect_normal_convention(image, region).convention) {
    case NormalConvention::kDirectX:
      return surface::GreenChannel::kDown;
    case NormalConvention::kUnclear:
      return surface::GreenChannel::kUnclear;
    default:
      return surface::GreenChannel::kUp;
  }
}

std::vector<surface::GreenChannel> green_channels(const Scan& scan, const std::string& normals) {
  if (normals != "auto" && normals != "opengl" && normals != "directx")
    throw InputError("--normals", "", "'" + normals + "' is not known", "write auto, opengl or directx");
  std::vector<surface::GreenChannel> green(scan.materials.size(), normals == "directx"
                                                                      ? surface::GreenChannel::kDown
                                                                      : surface::GreenChannel::kUp);
  const auto has_normals = [](const ScanMaterial& material) { return !material.normal.empty(); };
  if (normals != "auto" || std::none_of(scan.materials.begin(), scan.materials.end(), has_normals))
    return green;
  const std::vector<ScanTriangle> triangles = triangulate(scan);
  const MeshTopology topology = mesh_topology(scan);
  const std::vector<uint32_t> chart_of_face = uv_charts(scan);
  for (size_t m = 0; m < green.size(); ++m)
    if (!scan.materials[m].normal.empty())
      green[m] = green_of(scan, triangles, topology, chart_of_face, static_cast<uint16_t>(m));
  return green;
}

/// Reads the files of --source and --cage and says in the options where they are.
void read_source(const BakeJob& job, BakeInputs& inputs) {
  bake::BakeSource& source = inputs.options.source;
  if (job.source.empty()) {
    if (!job.cage.empty() || job.wants_object_normals || job.reach_cm > 0)
      throw InputError("--source", "", "is missing: --cage, --reach and --object-normals are for it",
                       "name the high-resolution mesh");
    return;
  }
  inputs.source = read_scan(job.source);
  turn_up(inputs.source, inputs.regions.up);  // it lies in the scan's frame
  source.scan = &inputs.source;
  source.sha256 = sha256_of_file(job.source);
  source.unit_cm = !job.source_unit.empty() ? resolve_unit_cm(inputs.source, job.source_unit)
                                            : inputs.source.stated_unit_cm.value_or(inputs.options.unit_cm);
  source.green = green_channels(inputs.source, job.normals);
  source.reach_cm = job.reach_cm;
  source.max_missed_share = job.max_missed_percent / 100;
  source.max_overlap_share = job.max_overlap_percent / 100;
  source.wants_object_normals = job.wants_object_normals;
  if (job.cage.empty()) return;
  inputs.cage = read_scan(job.cage);
  turn_up(inputs.cage, inputs.regions.up);
  source.cage = &inputs.cage;
}

/// weights.exr of each material, where `label` wrote one.
std::vector<fs::path> class_weights(const Scan& scan, const fs::path& regions) {
  std::vector<std::string> names;
  for (const ScanMaterial& material : scan.materials) names.push_back(material.name);
  std::vector<fs::path> files;
  for (const std::string& folder : texture_set_folders(names)) {
    files.push_back(regions / "maps" / folder / "weights.exr");
    if (!fs::is_regular_file(files.back())) files.back().clear();
  }
  return files;
}

/// Half is 1: darker texels were made brighter.
void write_divisor(const fs::path& file, Image divisor) {
  for (float& value : divisor.values) value *= 0.5f;
  write_png(file, divisor);
}

}  // namespace

std::unique_ptr<BakeInputs> read_bake_inputs(const BakeJob& job) {
  auto inputs = std::make_unique<BakeInputs>();
  inputs->regions = regions_of_scan(job);
  inputs->table =
      read_material_table(job.materials.empty() ? program_file("assets/materials.xml") : job.materials);
  inputs->scan = read_scan(job.scan);
  turn_up(inputs->scan, inputs->regions.up);
  const Scan& scan = inputs->scan;
  const std::optional<std::string> unit = job.unit.empty() ? std::nullopt : std::optional(job.unit);
  bake::BakeOptions& options = inputs->options;
  options.size_px = job.size_px;
  options.unit_cm = resolve_unit_cm(scan, unit);
  expect_upright(scan, options.unit_cm, inputs->regions.up);
  options.name = job.name.empty() ? job.scan.stem().string() : job.name;
  options.quiet = job.quiet;
  options.mends_seams = !job.keeps_seams;
  options.wants_mips = job.wants_mips;
  options.class_weights = class_weights(scan, job.regions);
  read_source(job, *inputs);
  if (job.source.empty()) options.green = green_channels(scan, job.normals);
  options.unit_reason = unit ? "as given" : guess_unit(scan).reason;
  return inputs;
}

nlohmann::ordered_json to_json(const BakeScanReport& report) {
  nlohmann::ordered_json json = to_json(report.bake);
  if (!report.delight.regions.empty()) json["delight"] = to_json(report.delight);
  return json;
}

std::string to_text(const BakeScanReport& report) {
  return to_text(report.bake) + to_text(report.delight);
}

BakeScanReport bake_scan(const BakeJob& job) {
  AtomicFolder folder(job.output, "model", {job.scan, job.regions, job.materials, job.source, job.cage});
  const std::unique_ptr<BakeInputs> inputs = read_bake_inputs(job);
  for (const Scan* scan : {&inputs->scan, &inputs->source}) folder.protect(picture_files(*scan));
  bake::CanonicalMesh mesh = bake::canonical_mesh(inputs->scan, inputs->regions, inputs->options.unit_cm);
  BakeScanReport report;
  const fs::path scratch = folder.path() / "delit";
  if (job.delights) {
    if (!job.source.empty())
      throw InputError("--delight", "", "is for the scan's own pictures, not for those of a source",
                       "delight the source by a bake of its own, or leave --delight out");
    fs::create_directories(scratch);
    report.delight = delight(inputs->scan, mesh, scratch);
  }
  report.bake =
      bake::bake_to_folder(inputs->scan, std::move(mesh), inputs->table, inputs->options, folder.path());
  fs::remove_all(scratch);
  for (size_t i = 0; i < report.delight.divisors.size(); ++i)
    write_divisor(folder.path() / "maps" / report.delight.set_folders[i] / "divisor.png",
                  report.delight.divisors[i]);
  if (job.delights)
    write_file_atomically(folder.path() / "report.json", json_text(to_json(report), 2) + "\n");
  folder.commit();
  return report;
}

}  // namespace ohb::commands
