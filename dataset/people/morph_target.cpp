#include "dataset/people/morph_target.h"

#include "dataset/people/asset_file.h"

namespace ohb::people {
namespace fs = std::filesystem;

MorphTarget read_morph_target(const fs::path& file, size_t vertex_count) {
  const std::string text = read_asset_text(file);
  AssetLines lines(file, text);
  MorphTarget target;
  while (lines.next()) {
    target.vertices.push_back(lines.index("vertex", vertex_count));
    Vec3f move;
    for (int axis = 0; axis < 3; ++axis) move[axis] = lines.number("move");
    if (!lines.is_at_end()) lines.fail("there is more than a vertex and its move");
    target.moves_dm.push_back(move);
    if (target.vertices.size() > vertex_count) lines.fail("there are more lines than the base has vertices");
  }
  return target;
}

MorphTargets::MorphTargets(fs::path folder, size_t vertex_count)
    : folder_(std::move(folder)), vertex_count_(vertex_count) {}

std::shared_ptr<const MorphTarget> MorphTargets::find(const std::string& name) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto known = read_.find(name);
  if (known != read_.end()) return known->second;
  std::shared_ptr<const MorphTarget> target;
  for (const char* ending : {".target.gz", ".target"}) {
    const fs::path file = folder_ / (name + ending);
    std::error_code error;
    if (!fs::is_regular_file(file, error)) continue;
    target = std::make_shared<MorphTarget>(read_morph_target(file, vertex_count_));
    break;
  }
  return read_[name] = target;
}

}  // namespace ohb::people
