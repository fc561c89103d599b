#include "dataset/model/model_identity.h"

#include <exception>
#include <vector>

#include "dataset/model/atomic_file.h"
#include "dataset/model/parallel.h"
#include "dataset/model/xml_document.h"

namespace ohb {
namespace fs = std::filesystem;

std::string model_identity(const fs::path& folder) {
  std::vector<fs::path> files = {"model.xml", "mesh.obj", "faces.bin"};
  const XmlDocument xml(folder / "model.xml", "model");
  for (const pugi::xml_node& set : xml.root().children("texture_set"))
    for (const pugi::xml_node& map : set.children("map"))
      if (const std::string name = xml.text(map, "name"); name != "displacement")
        files.push_back(fs::path("maps") / xml.text(set, "folder") / (name + ".exr"));
  std::vector<std::string> hashes(files.size());
  std::vector<std::exception_ptr> failures(files.size());
  parallel_for_each(0, static_cast<int>(files.size()), [&](int i) {
    const auto k = static_cast<size_t>(i);
    try {
      hashes[k] = sha256_of_file(folder / files[k]);
    } catch (...) {
      failures[k] = std::current_exception();
    }
  });
  std::string text;
  for (size_t k = 0; k < files.size(); ++k) {
    if (failures[k]) std::rethrow_exception(failures[k]);
    text += files[k].generic_string() + " " + hashes[k] + "\n";
  }
  return sha256_of(text);
}

}  // namespace ohb
