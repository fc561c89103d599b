// Morph targets: how far each vertex of the base mesh moves for one trait.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "dataset/model/vec.h"

namespace ohb::people {

struct MorphTarget {
  std::vector<uint32_t> vertices;
  std::vector<Vec3f> moves_dm;  // one a vertex
};

/// A .target or .target.gz for a base mesh of that many vertices. Throws InputError naming the line.
MorphTarget read_morph_target(const std::filesystem::path& file, size_t vertex_count);

/// The targets below a folder, each read once; may be asked from several threads.
class MorphTargets {
 public:
  /// `folder` holds <name>.target or <name>.target.gz, with sub-folders in the names.
  MorphTargets(std::filesystem::path folder, size_t vertex_count);

  /// Null if there is no such file. Throws as read_morph_target.
  std::shared_ptr<const MorphTarget> find(const std::string& name) const;

 private:
  std::filesystem::path folder_;
  size_t vertex_count_;
  mutable std::mutex mutex_;
  mutable std::map<std::string, std::shared_ptr<const MorphTarget>> read_;
};

}  // namespace ohb::people
