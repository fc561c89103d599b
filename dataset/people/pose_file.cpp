// Poses as Biovision hierarchies (.bvh), of which MakeHuman's hold one frame.
#include <fmt/format.h>

#include <cmath>

#include "dataset/model/error.h"
#include "dataset/people/asset_file.h"
#include "dataset/people/skeleton.h"

namespace ohb::people {
namespace fs = std::filesystem;
namespace {

constexpr double kRadians = 3.14159265358979323846 / 180;
constexpr size_t kMaxJoints = 4096;

struct Joint {
  std::string name;
  int parent = -1;
  Vec3f offset;
  std::string channels;  // p or r, and the axis: "pxpypzrxryrz"
};

/// The rest of an OFFSET or CHANNELS line.
void read_joint_line(AssetLines& lines, const std::string& key, Joint& joint) {
  if (key == "OFFSET") {
    for (int axis = 0; axis < 3; ++axis) joint.offset[axis] = lines.number("offset");
    return;
  }
  const uint32_t count = lines.index("number of channels", 7);
  for (uint32_t i = 0; i < count; ++i) {
    const std::string channel(lines.word());
    if (channel.size() < 9 || channel[0] < 'X' || channel[0] > 'Z')
      lines.fail("knows no channel '" + channel.substr(0, 40) + "'");
    joint.channels += channel.substr(1) == "position" ? 'p' : 'r';
    joint.channels += static_cast<char>(channel[0] - 'X' + 'x');
  }
}

/// The file's joints in order; `line` stands on MOTION afterwards.
std::vector<Joint> read_hierarchy(AssetLines& lines) {
  std::vector<Joint> joints;
  std::vector<int> stack;  // -1: an end site
  int pending = -2;
  while (lines.next()) {
    const std::string key(lines.word());
    if (key == "ROOT" || key == "JOINT") {
      Joint joint;
      joint.name = lines.rest();
      joint.parent = stack.empty() ? -1 : stack.back();
      pending = static_cast<int>(joints.size());
      joints.push_back(joint);
      if (joints.size() > kMaxJoints) lines.fail("there are more than 4096 joints");
    } else if (key == "End") {
      pending = -1;
    } else if (key == "{") {
      if (pending == -2) lines.fail("a brace opens without a joint");
      stack.push_back(pending);
      pending = -2;
    } else if (key == "}") {
      if (stack.empty()) lines.fail("a brace closes that none opened");
      stack.pop_back();
    } else if (key == "OFFSET" || key == "CHANNELS") {
      if (stack.empty()) lines.fail("stands outside a joint");
      if (stack.back() >= 0) read_joint_line(lines, key, joints[static_cast<size_t>(stack.back())]);
    } else if (key == "MOTION") {
      if (!stack.empty() || joints.empty()) lines.fail("the hierarchy is not closed");
      return joints;
    }
  }
  lines.fail("there is no MOTION");
}

/// A turn about an axis of the file, in our axes: (x, y, z) of a file that is Z up is (x, z, -y) here.
Affine turn_of(char axis, double degrees, bool z_up) {
  const double angle = degrees * kRadians;
  if (axis == 'x') return rotation_about({1, 0, 0}, angle);
  if (!z_up) return rotation_about(axis == 'y' ? Vec3f{0, 1, 0} : Vec3f{0, 0, 1}, angle);
  return axis == 'y' ? rotation_about({0, 0, 1}, -angle) : rotation_about({0, 1, 0}, angle);
}

}  // namespace

Pose read_pose(const fs::path& file) {
  const std::string text = read_asset_text(file);
  AssetLines lines(file, text);
  const std::vector<Joint> joints = read_hierarchy(lines);
  Vec3f shin;
  for (const Joint& joint : joints)
    if (joint.parent >= 0 && joints[static_cast<size_t>(joint.parent)].name == "upperleg02.L")
      shin = joint.offset;
  const bool z_up = std::fabs(shin.z) > std::fabs(shin.y);
  bool has_frame = false;
  while (!has_frame && lines.next()) {
    const std::string text_line = lines.rest();
    has_frame = text_line.rfind("Frame", 0) != 0;
  }
  if (!has_frame) lines.fail("there is no frame");
  Pose pose;
  for (const Joint& joint : joints) {
    Affine turn;
    for (size_t i = 0; i < joint.channels.size(); i += 2) {
      const float value = lines.number(("value of " + joint.name).c_str());
      const char axis = joint.channels[i + 1];
      if (joint.channels[i] == 'r') turn = turn * turn_of(axis, static_cast<double>(value), z_up);
    }
    pose.rotations[joint.name] = turn;
  }
  return pose;
}

}  // namespace ohb::people
