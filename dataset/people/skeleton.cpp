#include "dataset/people/skeleton.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "dataset/model/error.h"
#include "dataset/model/json_text.h"
#include "dataset/people/asset_file.h"

namespace ohb::people {
namespace fs = std::filesystem;
namespace {

constexpr const char* kMend = "take MakeHuman's own rig files";
constexpr size_t kMaxBones = 4096;

using Json = nlohmann::json;

Json read_json(const fs::path& file) {
  return parse_json(read_asset_text(file), file.string(), kListingLimits);
}

std::vector<uint32_t> joint_vertices(const Json& joints, const std::string& name, size_t count) {
  std::vector<uint32_t> vertices;
  for (const Json& vertex : joints.at(name)) {
    const auto index = vertex.get<size_t>();
    if (index >= count)
      throw InputError("", "joint '" + name + "'", fmt::format("vertex {} of {}", index, count), kMend);
    vertices.push_back(static_cast<uint32_t>(index));
  }
  if (vertices.empty()) throw InputError("", "joint '" + name + "'", "has no vertices", kMend);
  return vertices;
}

/// Parents before their children.
std::vector<Bone> sorted_bones(const Json& rig, size_t count) {
  const Json& bones = rig.at("bones");
  if (bones.size() > kMaxBones) throw InputError("", "bones", "are more than 4096", kMend);
  std::vector<Bone> sorted;
  std::map<std::string, int> placed;
  while (sorted.size() < bones.size()) {
    const size_t before = sorted.size();
    for (const auto& [name, bone] : bones.items()) {
      if (placed.count(name)) continue;
      const std::string parent = bone.at("parent").is_null() ? "" : bone.at("parent").get<std::string>();
      if (!parent.empty() && !bones.contains(parent))
        throw InputError("", "bone '" + name + "'", "its parent '" + parent + "' is not there", kMend);
      if (!parent.empty() && !placed.count(parent)) continue;
      placed[name] = static_cast<int>(sorted.size());
      sorted.push_back({name, parent.empty() ? -1 : placed[parent],
                        joint_vertices(rig.at("joints"), bone.at("head").get<std::string>(), count),
                        joint_vertices(rig.at("joints"), bone.at("tail").get<std::string>(), count)});
    }
    if (sorted.size() == before) throw InputError("", "bones", "are their own ancestors", kMend);
  }
  return sorted;
}

constexpr size_t kMostShares = 6;

/// The largest shares, made to sum 1.
void normalise(VertexBones& shares) {
  std::sort(shares.begin(), shares.end(), [](const BoneShare& a, const BoneShare& b) {
    return a.weight > b.weight || (a.weight == b.weight && a.bone < b.bone);
  });
  if (shares.size() > kMostShares) shares.resize(kMostShares);
  float sum = 0;
  for (const BoneShare& share : shares) sum += share.weight;
  if (!(sum > 0)) return shares.clear();
  for (BoneShare& share : shares) share.weight /= sum;
}

void read_weights(const Json& weights, Skeleton& skeleton) {
  for (const auto& [name, list] : weights.at("weights").items()) {
    const int bone = skeleton.find(name);
    if (bone < 0) continue;
    for (const Json& pair : list) {
      const auto vertex = pair.at(0).get<size_t>();
      const auto weight = pair.at(1).get<float>();
      if (vertex >= skeleton.vertex_bones.size() || !std::isfinite(weight))
        throw InputError("", "weights of '" + name + "'",
                         fmt::format("vertex {} of {}", vertex, skeleton.vertex_bones.size()), kMend);
      if (weight > 0) skeleton.vertex_bones[vertex].push_back({static_cast<uint16_t>(bone), weight});
    }
  }
  for (VertexBones& shares : skeleton.vertex_bones) normalise(shares);
}

/// Runs `read`; what JSON and we complain about gets the file's name.
template <typename Read>
auto naming(const fs::path& file, const Read& read) {
  try {
    return read();
  } catch (const Json::exception& error) {
    throw InputError(file.string(), "", error.what(), kMend);
  } catch (const InputError& error) {
    throw InputError(file.string(), "", error.what(), "");
  }
}

}  // namespace

int Skeleton::find(const std::string& name) const {
  for (size_t i = 0; i < bones.size(); ++i)
    if (bones[i].name == name) return static_cast<int>(i);
  return -1;
}

Skeleton read_skeleton(const fs::path& rig, const fs::path& weights, size_t base_vertex_count) {
  Skeleton skeleton;
  const Json rig_json = read_json(rig), weights_json = read_json(weights);
  skeleton.bones = naming(rig, [&] { return sorted_bones(rig_json, base_vertex_count); });
  skeleton.vertex_bones.resize(base_vertex_count);
  naming(weights, [&] {
    read_weights(weights_json, skeleton);
    return 0;
  });
  return skeleton;
}

Vec3f joint_at(const std::vector<uint32_t>& vertices, const std::vector<Vec3f>& base) {
  Vec3f sum;
  for (const uint32_t vertex : vertices) sum += base[vertex];
  return sum / static_cast<float>(vertices.size());
}

Affine rotation_about(Vec3f axis, double angle) {
  const double c = std::cos(angle), s = std::sin(angle), x = axis.x, y = axis.y, z = axis.z;
  Affine r;
  r.m = {c + x * x * (1 - c),     x * y * (1 - c) - z * s, x * z * (1 - c) + y * s, 0,
         y * x * (1 - c) + z * s, c + y * y * (1 - c),     y * z * (1 - c) - x * s, 0,
         z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c),     0};
  return r;
}

Affine part_of_rotation(const Affine& r, double share) {
  const double cosine = std::clamp((r(0, 0) + r(1, 1) + r(2, 2) - 1) / 2, -1.0, 1.0);
  const Vec3f axis{static_cast<float>(r(2, 1) - r(1, 2)), static_cast<float>(r(0, 2) - r(2, 0)),
                   static_cast<float>(r(1, 0) - r(0, 1))};
  // No axis: no turn, or a half turn, which no pose of a standing person has.
  if (length(axis) < 1e-6f) return share < .5 ? Affine() : r;
  return rotation_about(normalised(axis), share * std::acos(cosine));
}

std::vector<Affine> bone_motions(const Skeleton& skeleton, const std::vector<Vec3f>& base, const Pose& pose) {
  std::vector<Affine> motions(skeleton.bones.size());
  for (size_t i = 0; i < skeleton.bones.size(); ++i) {
    const Bone& bone = skeleton.bones[i];
    const Affine above = bone.parent < 0 ? Affine() : motions[static_cast<size_t>(bone.parent)];
    const auto turn = pose.rotations.find(bone.name);
    if (turn == pose.rotations.end()) {
      motions[i] = above;
      continue;
    }
    const Vec3f head = joint_at(bone.head, base);
    Affine about = turn->second;  // T(head) R T(-head)
    const Vec3f moved = transformed(about, head.x, head.y, head.z);
    for (int row = 0; row < 3; ++row) about(row, 3) = static_cast<double>(head[row]) - moved[row];
    motions[i] = above * about;
  }
  return motions;
}

std::vector<VertexBones> garment_bones(const Garment& garment, const Skeleton& skeleton) {
  std::vector<VertexBones> all;
  all.reserve(garment.anchors.size());
  for (const Anchor& anchor : garment.anchors) {
    VertexBones mixed;
    for (size_t i = 0; i < 3; ++i)
      for (const BoneShare& share : skeleton.vertex_bones[anchor.vertices[i]]) {
        const float weight = std::max(anchor.weights[i], 0.0f) * share.weight;
        const auto same = std::find_if(mixed.begin(), mixed.end(),
                                       [&](const BoneShare& other) { return other.bone == share.bone; });
        if (same != mixed.end())
          same->weight += weight;
        else if (weight > 0)
          mixed.push_back({share.bone, weight});
      }
    normalise(mixed);
    all.push_back(std::move(mixed));
  }
  return all;
}

std::vector<Vec3f> skinned(const std::vector<Vec3f>& rest, const std::vector<VertexBones>& bones,
                           const std::vector<Affine>& motions) {
  std::vector<Vec3f> posed(rest.size());
  for (size_t i = 0; i < rest.size(); ++i) {
    if (bones[i].empty()) {
      posed[i] = transformed(motions[0], rest[i].x, rest[i].y, rest[i].z);
      continue;
    }
    Affine mean;
    mean.m.fill(0);
    for (const BoneShare& share : bones[i])
      for (size_t k = 0; k < 12; ++k)
        mean.m[k] += static_cast<double>(share.weight) * motions[share.bone].m[k];
    posed[i] = transformed(mean, rest[i].x, rest[i].y, rest[i].z);
  }
  return posed;
}

}  // namespace ohb::people
