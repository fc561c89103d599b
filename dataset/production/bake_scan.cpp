#include "dataset/production/bake_scan.h"

#include "dataset/model/atomic_file.h"
#include "dataset/model/data_files.h"
#include "dataset/model/error.h"

namespace ohb {
namespace {

/// cm a unit, from the word or what the file states.
double unit_cm_of_job(const BakeJob& job, const Scan& scan) {
  if (job.unit == "mm") return 0.1;
  if (job.unit == "cm") return 1;
  if (job.unit == "m") return 100;
  if (job.unit == "inch") return 2.54;
  if (job.unit.empty() && scan.stated_unit_cm) return *scan.stated_unit_cm;
  const Bounds bounds = bounds_of(scan.positions);
  const float height = bounds.high.y - bounds.low.y;
  if (job.unit.empty() && height >= 140 && height <= 210) return 1;
  throw InputError(job.scan.string(), "--unit", "the unit is not known", "give mm, cm, m or inch");
}

}  // namespace

BakeReport bake_scan(const BakeJob& job) {
  AtomicFolder folder(job.output);
  const Regions regions = read_regions(job.regions);
  const MaterialTable table =
      read_material_table(job.materials.empty() ? program_file("assets/materials.xml") : job.materials);
  const std::string scan_sha256 = sha256_of_file(job.scan);
  if (regions.scan_sha256 != scan_sha256)
    throw InputError(
        job.regions.string(), "",
        "was made from another scan than " + job.scan.filename().string() + " (the hash of the file differs)",
        "run `label` on this scan");
  const Scan scan = read_scan(job.scan);
  BakeOptions options;
  options.size_px = job.size_px;
  options.unit_cm = unit_cm_of_job(job, scan);
  options.name = job.name.empty() ? job.scan.stem().string() : job.name;
  options.quiet = job.quiet;
  BakeReport report = bake_to_folder(scan, regions, table, options, folder.path());
  folder.commit();
  return report;
}

}  // namespace ohb
