#include "dataset/model/regions.h"

#include "dataset/model/atomic_file.h"
#include "dataset/model/conventions.h"
#include "dataset/model/text_lines.h"
#include "dataset/model/xml_document.h"

namespace ohb {
namespace fs = std::filesystem;
namespace {

constexpr uint64_t kMaxFaces = 0xffffffffu;

std::string regions_xml(const Regions& regions) {
  std::array<uint64_t, kClassCount> faces_of_class{};
  uint64_t unlabelled = 0;
  for (uint8_t c : regions.face_class) ++(c < kClassCount ? faces_of_class[c] : unlabelled);
  pugi::xml_document document;
  pugi::xml_node root = document.append_child("regions");
  root.append_attribute("schema") = "1.0";
  root.append_attribute("scan_sha256") = regions.scan_sha256.c_str();
  if (!regions.up.empty()) root.append_attribute("up") = regions.up.c_str();
  root.append_attribute("faces") = static_cast<unsigned long long>(regions.face_class.size());
  root.append_attribute("unlabelled") = static_cast<unsigned long long>(unlabelled);
  root.append_child("generator").append_attribute("version") = OHB_VERSION;
  for (int c = 0; c < kClassCount; ++c) {
    pugi::xml_node node = root.append_child("class");
    node.append_attribute("index") = c;
    node.append_attribute("name") = kClassNames[c];
    node.append_attribute("faces") = static_cast<unsigned long long>(faces_of_class[c]);
  }
  append_conventions(root);
  return xml_text(document);
}

/// The class that each index means. Throws InputError for a name that is none of ours.
std::vector<uint8_t> meanings(const fs::path& file, const std::vector<std::string>& classes) {
  std::vector<uint8_t> meaning;
  for (uint8_t c = 0; c < kClassCount && classes.empty(); ++c) meaning.push_back(c);
  for (const std::string& name : classes) {
    meaning.push_back(class_from_name(name));
    if (meaning.back() == kUnlabelled && name != "unlabelled")
      throw InputError(file.string(), "classes", "'" + name + "' is not known",
                       "use " + class_list(", ", ", ") + " or unlabelled");
  }
  return meaning;
}

}  // namespace

std::string class_list(const std::string& between, const std::string& last) {
  std::string text = kClassNames[0];
  for (int c = 1; c < kClassCount; ++c) text += (c + 1 < kClassCount ? between : last) + kClassNames[c];
  return text;
}

MaterialClass class_from_name(const std::string& name) {
  for (int c = 0; c < kClassCount; ++c)
    if (name == kClassNames[c]) return static_cast<MaterialClass>(c);
  return kUnlabelled;
}

std::vector<uint8_t> read_face_classes(const fs::path& file, size_t face_count,
                                       const std::vector<std::string>& classes) {
  const std::vector<uint8_t> meaning = meanings(file, classes);
  const std::string content = read_file(file);
  std::vector<uint8_t> face_class;
  face_class.reserve(face_count);
  for (TextLines lines(file, content); lines.next();) {
    long long index = 0;
    const bool is_index = parse_integer(lines.line(), index);
    const bool is_known =
        index == kUnlabelled || (index >= 0 && index < static_cast<long long>(meaning.size()));
    if (!is_index || !is_known)
      throw InputError(file.string(), lines.place(),
                       "\"" + std::string(lines.line().substr(0, 40)) + "\" is no class index",
                       "write one index a line, 0 to " + std::to_string(meaning.size() - 1) + " or 255");
    face_class.push_back(index == kUnlabelled ? uint8_t{kUnlabelled} : meaning[static_cast<size_t>(index)]);
    if (face_class.size() > face_count) break;
  }
  if (face_class.size() != face_count)
    throw InputError(file.string(), "",
                     face_class.size() > face_count
                         ? "has more lines than the scan has faces (" + std::to_string(face_count) + ")"
                         : "has " + std::to_string(face_class.size()) + " lines, the scan has " +
                               std::to_string(face_count) + " faces",
                     "give the classes of this scan, one line a face in the order of the file");
  return face_class;
}

void write_regions(const fs::path& folder, const Regions& regions) {
  make_folders(folder);
  std::string text;
  text.reserve(regions.face_class.size() * 2);
  for (uint8_t c : regions.face_class) text += std::to_string(c) + "\n";
  write_file_atomically(folder / "faces.txt", text);
  write_file_atomically(folder / "regions.xml", regions_xml(regions));
}

Regions read_regions(const fs::path& folder) {
  if (!fs::is_directory(folder))
    throw InputError(folder.string(), "", "no such folder", "give the folder that `label -o` wrote");
  const XmlDocument xml(folder / "regions.xml", "regions");
  xml.expect_attributes(xml.root(), {"schema", "scan_sha256", "up", "faces", "unlabelled"});
  const std::string schema = xml.text(xml.root(), "schema");
  if (schema.rfind("1.", 0) != 0)
    throw xml.error(xml.root(), "schema " + schema + " is not known here (1.x is)", "use a newer version");
  for (const pugi::xml_node& node : xml.root().children("class")) {
    const uint64_t index = xml.count(node, "index", kClassCount - 1);
    if (xml.text(node, "name") != kClassNames[index])
      throw xml.error(node,
                      "class " + std::to_string(index) + " is '" + xml.text(node, "name") + "', not '" +
                          kClassNames[index] + "'",
                      "label the scan again");
  }
  Regions regions;
  regions.scan_sha256 = xml.text(xml.root(), "scan_sha256");
  regions.up = xml.text_or(xml.root(), "up", "");
  regions.face_class = read_face_classes(folder / "faces.txt", xml.count(xml.root(), "faces", kMaxFaces), {});
  return regions;
}

}  // namespace ohb
