#include "dataset/production/bake_scan.h"

#include "dataset/model/atomic_file.h"
#include "dataset/model/data_files.h"
#include "dataset/model/error.h"
#include "dataset/model/scan_unit.h"

namespace ohb {
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
  options.unit_cm =
      resolve_unit_cm(scan, job.unit.empty() ? std::nullopt : std::optional<std::string>(job.unit));
  options.name = job.name.empty() ? job.scan.stem().string() : job.name;
  options.quiet = job.quiet;
  BakeReport report = bake_to_folder(scan, regions, table, options, folder.path());
  folder.commit();
  return report;
}

}  // namespace ohb
