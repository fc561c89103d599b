#include "dataset/environments/library_list.h"

#include <algorithm>

#include "dataset/model/xml_document.h"

namespace ohb::environments {
namespace {

constexpr uint64_t kVersion = 1;
constexpr double kMaxRadiance = 1e30;
constexpr uint64_t kMaxCount = uint64_t{1} << 48;

void append(pugi::xml_node parent, const LibraryEntry& entry) {
  pugi::xml_node node = parent.append_child("environment");
  const auto set = [&](const char* name, const std::string& value) {
    node.append_attribute(name) = value.c_str();
  };
  set("id", entry.id);
  set("category", entry.category);
  set("licence", entry.licence);
  set("source", entry.source);
  set("origin", entry.origin);
  set("made_from", entry.made_from);
  set("sha256", entry.sha256);
  set("bytes", std::to_string(entry.bytes));
  set("width", std::to_string(entry.width_px));
  set("values", entry.values);
  set("mean_r", shortest(entry.light.mean[0]));
  set("mean_g", shortest(entry.light.mean[1]));
  set("mean_b", shortest(entry.light.mean[2]));
  set("peak", shortest(entry.light.peak));
  set("brightest_x", shortest(entry.light.brightest.x));
  set("brightest_y", shortest(entry.light.brightest.y));
  set("brightest_z", shortest(entry.light.brightest.z));
  set("mended_nan", std::to_string(entry.mended.nan));
  set("mended_infinite", std::to_string(entry.mended.infinite));
  set("mended_negative", std::to_string(entry.mended.negative));
}

LibraryEntry entry_of(const XmlDocument& xml, pugi::xml_node node) {
  xml.expect_attributes(node, {"id",          "category",   "licence",         "source",
                               "origin",      "made_from",  "sha256",          "bytes",
                               "width",       "values",     "mean_r",          "mean_g",
                               "mean_b",      "peak",       "brightest_x",     "brightest_y",
                               "brightest_z", "mended_nan", "mended_infinite", "mended_negative"});
  LibraryEntry entry;
  entry.id = xml.text(node, "id");
  if (id_of_name(entry.id) != entry.id)
    throw xml.error(node, "id=\"" + entry.id + "\" is no id of an environment",
                    "use a-z, 0-9, '_' and '-', at most 64");
  entry.category = xml.text(node, "category");
  entry.licence = xml.text(node, "licence");
  entry.source = xml.text(node, "source");
  entry.origin = xml.text(node, "origin");
  entry.made_from = xml.text(node, "made_from");
  entry.sha256 = xml.text(node, "sha256");
  entry.bytes = xml.count(node, "bytes", kMaxCount);
  entry.width_px = static_cast<int>(xml.count(node, "width", 65536));
  entry.values = xml.text(node, "values");
  entry.light.mean = {xml.number(node, "mean_r", 0, kMaxRadiance),
                      xml.number(node, "mean_g", 0, kMaxRadiance),
                      xml.number(node, "mean_b", 0, kMaxRadiance)};
  entry.light.peak = xml.number(node, "peak", 0, kMaxRadiance);
  entry.light.brightest = {static_cast<float>(xml.number(node, "brightest_x", -1, 1)),
                           static_cast<float>(xml.number(node, "brightest_y", -1, 1)),
                           static_cast<float>(xml.number(node, "brightest_z", -1, 1))};
  entry.mended = {xml.count(node, "mended_nan", kMaxCount), xml.count(node, "mended_infinite", kMaxCount),
                  xml.count(node, "mended_negative", kMaxCount)};
  return entry;
}

}  // namespace

std::string library_list_text(const std::vector<LibraryEntry>& entries) {
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "UTF-8";
  pugi::xml_node root = document.append_child("environments");
  root.append_attribute("version") = static_cast<unsigned>(kVersion);
  root.append_attribute("radiance") =
      "linear Rec. 709; row 0 is +Y, u = 1/2 + atan2(z, x) / 2 pi; mean over the sphere by solid angle, "
      "peak as luminance";
  for (const LibraryEntry& entry : entries) append(root, entry);
  return xml_text(document);
}

std::vector<LibraryEntry> read_library_list(const std::filesystem::path& file) {
  const XmlDocument xml(file, "environments");
  xml.expect_attributes(xml.root(), {"version", "radiance"});
  if (xml.count(xml.root(), "version", 1000000) != kVersion)
    throw xml.error(xml.root(), "is of version " + xml.text(xml.root(), "version") + ", not 1",
                    "use the version of openhumanbrdf that wrote it, or a newer one");
  xml.expect_children(xml.root(), {"environment"});
  std::vector<LibraryEntry> entries;
  for (const pugi::xml_node node : xml.root().children("environment")) {
    entries.push_back(entry_of(xml, node));
    if (entries.size() > 1 && !(entries[entries.size() - 2].id < entries.back().id))
      throw xml.error(node, "id=\"" + entries.back().id + "\" occurs twice or is out of order",
                      "keep one, sorted by id");
  }
  return entries;
}

}  // namespace ohb::environments
