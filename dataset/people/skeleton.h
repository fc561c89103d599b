// The rig: bones that hang on the morphed base, weights, poses, and linear blend skinning.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "dataset/model/affine.h"
#include "dataset/people/garment_file.h"

namespace ohb::people {

struct Bone {
  std::string name;
  int parent = -1;                   // before it in the list; -1: none
  std::vector<uint32_t> head, tail;  // base vertices whose mean is the joint
};

/// A bone's share of a vertex; those of a vertex sum to 1.
struct BoneShare {
  uint16_t bone = 0;
  float weight = 0;
};
using VertexBones = std::vector<BoneShare>;

struct Skeleton {
  std::vector<Bone> bones;
  std::vector<VertexBones> vertex_bones;  // one a base vertex; empty: moves with the root

  /// -1 if there is none of that name.
  int find(const std::string& name) const;
};

/// A .mhskel and its .mhw. Throws InputError: not JSON, an unknown parent, a circle of parents, an index out
/// of range, a joint without vertices.
Skeleton read_skeleton(const std::filesystem::path& rig, const std::filesystem::path& weights,
                       size_t base_vertex_count);

/// Rotations by bone, about the world's axes at the bone's head; those that are not there stand still.
struct Pose {
  std::map<std::string, Affine> rotations;
};

/// The first frame of a .bvh, turned to Y up where it is Z up. Moves are not read: people stand on the
/// ground. Throws InputError naming the line.
Pose read_pose(const std::filesystem::path& file);

/// Rotation by `angle` (radians) about a unit axis.
Affine rotation_about(Vec3f axis, double angle);

/// The rotation's share (0 to 1) from rest.
Affine part_of_rotation(const Affine& rotation, double share);

/// How each bone moves points of the rest pose.
std::vector<Affine> bone_motions(const Skeleton& skeleton, const std::vector<Vec3f>& base, const Pose& pose);

/// Shares of a garment's vertex: the mean of its anchors' by weight, those below 0 counting as 0.
std::vector<VertexBones> garment_bones(const Garment& garment, const Skeleton& skeleton);

/// Moves rest positions by their bones.
std::vector<Vec3f> skinned(const std::vector<Vec3f>& rest, const std::vector<VertexBones>& bones,
                           const std::vector<Affine>& motions);

/// Mean of base vertices.
Vec3f joint_at(const std::vector<uint32_t>& vertices, const std::vector<Vec3f>& base);

}  // namespace ohb::people
