// The pictures that a scan's materials are made of, as files that a command reads.
#pragma once

#include <filesystem>
#include <vector>

#include "dataset/model/scan.h"

namespace ohb::commands {

/// Embedded pictures have no file of their own and are left out.
inline std::vector<std::filesystem::path> picture_files(const Scan& scan) {
  std::vector<std::filesystem::path> files;
  for (const ScanMaterial& material : scan.materials)
    for (const ScanPicture* picture : {&material.diffuse, &material.alpha, &material.normal})
      if (!picture->empty() && !picture->embedded) files.push_back(picture->file);
  return files;
}

}  // namespace ohb::commands
