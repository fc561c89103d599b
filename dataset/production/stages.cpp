#include "dataset/production/stages.h"

#include <algorithm>
#include <pugixml.hpp>

#include "dataset/commands/bake_scan.h"
#include "dataset/commands/label.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/map_table.h"
#include "dataset/model/model_identity.h"
#include "dataset/model/stopwatch.h"
#include "dataset/model/xml_document.h"
#include "dataset/production/units.h"

namespace ohb::production {
namespace fs = std::filesystem;
namespace {

/// The files of a folder that a command marked, the marker among them.
std::vector<fs::path> files_of(const fs::path& folder) {
  std::vector<fs::path> files{folder / ".openhumanbrdf"};
  if (const std::optional<FolderMarker> marker = ohb::read_marker(folder))
    for (const std::string& file : marker->files) files.push_back(folder / file);
  return files;
}

/// What a bake reads of REGIONS: the classes of faces and the weights along borders.
std::string regions_content(const fs::path& folder, FileHashes& hashes) {
  std::vector<fs::path> files;
  for (const char* name : {"regions.xml", "faces.txt"}) files.push_back(folder / name);
  std::error_code ignored;
  for (fs::recursive_directory_iterator entry(folder / "maps", ignored), end; !ignored && entry != end;
       entry.increment(ignored))
    if (entry->path().filename() == "weights.exr") files.push_back(entry->path());
  std::sort(files.begin(), files.end());
  std::string text;
  for (const fs::path& file : files)
    text += file.lexically_relative(folder).generic_string() + " " + hashes.of(file) + "\n";
  return sha256_of(text);
}

/// Labels the person if need be; gives the folder of regions.
fs::path label_person(const PlanPerson& person, const std::string& scan_hash, const Layout& layout,
                      FileHashes& hashes, const UnitDone& done) {
  if (!person.regions.empty()) return person.regions;
  std::string order;
  if (!person.is_automatic)
    for (const std::string& name : commands::class_order_of(person.labels, person.scan)) order += name + ",";
  const std::string hash = hash_of_parts({{"label", OHB_VERSION},
                                          {"scan", scan_hash},
                                          {"labels", person.is_automatic ? "auto" : hashes.of(person.labels)},
                                          {"classes", order},
                                          {"unit", person.unit}});
  const fs::path folder = layout.regions(person.id);
  if (done_marker(layout, person.id, "label", hash)) return folder;
  const Stopwatch watch;
  begin_unit(layout, person.id, "label");
  commands::LabelJob job;
  job.scan = person.scan;
  job.faces = person.labels;
  job.automatic = person.is_automatic;
  job.unit = person.unit;
  job.output = folder;
  commands::label_scan(job);
  finish_unit(layout, person.id, "label", files_of(folder), {hash, {}, {}});
  done("label", watch.wall_s());
  return folder;
}

/// The table with 0 for classes that the person has not.
MaterialTable needed_materials(const Plan& plan, const fs::path& regions) {
  MaterialTable table{};
  for (const uint8_t c : read_regions(regions).face_class)
    if (c < kClassCount) table[c] = plan.materials[c];
  return table;
}

}  // namespace

std::string materials_text(const MaterialTable& table) {
  pugi::xml_document document;
  pugi::xml_node root = document.append_child("materials");
  const pugi::xml_attribute schema = root.append_attribute("schema");
  root.attribute("schema") = "1";
  for (const MaterialMap& map : kMaterialMaps) {
    // Specular first, as since the first version: what `produce` has done is known by this text.
    const std::string name = std::string(map.name) + "_encoding";
    const bool is_first = map.value == &ClassMaterial::specular;
    pugi::xml_attribute encoding =
        is_first ? root.insert_attribute_after(name.c_str(), schema) : root.append_attribute(name.c_str());
    encoding = map.encoding;
  }
  append_materials(root, table);
  return xml_text(document);
}

BakedPerson bake_person(const Plan& plan, const PlanPerson& person, const Layout& layout, FileHashes& hashes,
                        const UnitDone& done) {
  make_folders(layout.person(person.id));
  const std::string scan_hash = hashes.of_scan(person.scan);
  const fs::path regions = label_person(person, scan_hash, layout, hashes, done);
  const std::string materials = materials_text(needed_materials(plan, regions));
  const std::string hash = hash_of_parts({{"bake", OHB_VERSION},
                                          {"scan", scan_hash},
                                          {"regions", regions_content(regions, hashes)},
                                          {"materials", materials},
                                          {"map_px", std::to_string(plan.map_px)},
                                          {"unit", person.unit},
                                          {"name", person.id}});
  const fs::path model = layout.model(person.id);
  if (const auto marker = done_marker(layout, person.id, "bake", hash);
      marker && marker->facts.count("identity"))
    return {model, marker->facts.at("identity")};
  const Stopwatch watch;
  begin_unit(layout, person.id, "bake");
  const fs::path table = layout.person(person.id) / "materials.xml";
  write_file_atomically(table, materials);
  commands::BakeJob job;
  job.scan = person.scan;
  job.regions = regions;
  job.materials = table;
  job.unit = person.unit;
  job.name = person.id;
  job.size_px = plan.map_px;
  job.output = model;
  job.quiet = true;
  commands::bake_scan(job);
  std::vector<fs::path> files = files_of(model);
  files.push_back(table);
  const std::string identity = model_identity(model);
  finish_unit(layout, person.id, "bake", files, {hash, {{"identity", identity}}, {}});
  done("bake", watch.wall_s());
  return {model, identity};
}

}  // namespace ohb::production
