#include "dataset/model/data_files.h"

#include <cstdlib>
#include <vector>

#include "dataset/model/error.h"

namespace ohb {
namespace fs = std::filesystem;

fs::path program_file(const fs::path& relative) {
  std::vector<fs::path> roots;
  if (const char* root = std::getenv("OPENHUMANBRDF_DATA")) roots.emplace_back(root);
  std::error_code unknown;
  const fs::path program = fs::read_symlink("/proc/self/exe", unknown);
  if (!unknown) {
    roots.push_back(program.parent_path() / ".." / "share" / "openhumanbrdf");
    for (fs::path up = program.parent_path(); up != up.root_path(); up = up.parent_path())
      roots.push_back(up);
  }
  for (const fs::path& root : roots)
    if (fs::exists(root / relative)) return fs::canonical(root / relative);
  throw InputError(relative.string(), "", "which belongs to the program, was not found",
                   "install the program with its share folder, or set OPENHUMANBRDF_DATA to it");
}

}  // namespace ohb
