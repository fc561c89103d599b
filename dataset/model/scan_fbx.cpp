#include "dataset/model/error.h"
#include "dataset/model/scan_readers.h"
namespace ohb {
Scan read_fbx(const std::filesystem::path& file) {
  throw InputError(file.string(), "", "FBX is not read yet", "");
}
}  // namespace ohb
