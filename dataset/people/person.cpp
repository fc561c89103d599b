#include "dataset/people/person.h"

#include <algorithm>
#include <cmath>

namespace ohb::people {
namespace {

constexpr float kDmInCm = 10;

/// Morphs so that the person is as tall as the recipe says: by the height slider, then evenly by what is left
/// (a few percent).
std::vector<Vec3f> morphed_body_cm(const Assets& assets, const Recipe& recipe) {
  BodySliders sliders = recipe.body;
  const auto body_of = [&] {
    std::vector<WeightedTarget> targets = macro_targets(sliders);
    targets.insert(targets.end(), recipe.face.begin(), recipe.face.end());
    return morphed(assets.base(), assets.targets(), targets);
  };
  const float wanted_dm = recipe.height_cm / kDmInCm;
  std::vector<Vec3f> body = body_of();
  // dm a unit of the slider, above and below its middle.
  constexpr float kSlope = 14, kSlopeBelow = 8;
  const float missing = wanted_dm - height_of(assets.base(), body);
  sliders.height = std::clamp(.5f + missing / (missing > 0 ? kSlope : kSlopeBelow), .3f, .75f);
  body = body_of();
  const float scale = kDmInCm * wanted_dm / height_of(assets.base(), body);
  for (Vec3f& position : body) position *= scale;
  return body;
}

Pose pose_of(const Assets& assets, const Recipe& recipe) {
  Pose pose = read_pose(assets.folder() / recipe.pose);
  for (auto& [bone, turn] : pose.rotations)
    turn = part_of_rotation(turn, static_cast<double>(recipe.pose_share));
  constexpr double kRadians = 3.14159265358979323846 / 180;
  for (const JointTurn& turn : recipe.turns) {
    Affine& rotation = pose.rotations[turn.bone];
    rotation = rotation * rotation_about(turn.axis, kRadians * static_cast<double>(turn.degrees));
  }
  for (const WornItem& item : recipe.clothes) {
    if (item.pose.empty()) continue;
    for (const auto& [bone, turn] : read_pose(assets.folder() / item.pose).rotations) {
      Affine& rotation = pose.rotations[bone];
      rotation = rotation * turn;
    }
  }
  return pose;
}

/// Files of garments are in decimetres.
std::vector<Vec3f> fitted_cm(const Garment& garment, std::vector<Vec3f> body_cm) {
  for (Vec3f& position : body_cm) position *= 1 / kDmInCm;
  std::vector<Vec3f> fit = fitted(garment, body_cm);
  for (Vec3f& position : fit) position *= kDmInCm;
  return fit;
}

/// Turns a pose about the vertical so that the hips face +Z.
void face_forward(const Assets& assets, std::vector<Affine>& motions) {
  const int root = assets.skeleton().find("root");
  const Affine& hips = motions[static_cast<size_t>(std::max(root, 0))];
  const double turn = std::atan2(hips(0, 2), hips(2, 2));
  const Affine back = rotation_about({0, 1, 0}, -turn);
  for (Affine& motion : motions) motion = back * motion;
}

/// Adds a thing that is worn on the body.
void put_on(const Assets& assets, const std::string& file, PartKind kind, const std::vector<Vec3f>& body_cm,
            Person& person) {
  Part part;
  part.kind = kind;
  part.garment = assets.garment(file);
  part.name = part.garment->file.stem().string();
  part.mesh = std::shared_ptr<const Scan>(part.garment, &part.garment->mesh);
  part.material = part.garment->material;
  part.rest_cm = fitted_cm(*part.garment, body_cm);
  part.bones = garment_bones(*part.garment, assets.skeleton());
  part.posed_cm = skinned(part.rest_cm, part.bones, person.motions);
  for (uint32_t face = 0; face < part.mesh->face_count(); ++face) part.faces.push_back(face);
  person.parts.push_back(std::move(part));
}

float height_of_joint(const Assets& assets, const char* bone, const std::vector<Vec3f>& body_cm) {
  const int index = assets.skeleton().find(bone);
  return index < 0 ? 0 : joint_at(assets.skeleton().bones[static_cast<size_t>(index)].head, body_cm).y;
}

}  // namespace

Person dress_person(const Assets& assets, const Recipe& recipe) {
  Person person;
  person.recipe = std::make_shared<Recipe>(recipe);
  const std::vector<Vec3f> body_cm = morphed_body_cm(assets, recipe);
  person.motions = bone_motions(assets.skeleton(), body_cm, pose_of(assets, recipe));
  face_forward(assets, person.motions);
  person.hips_cm = height_of_joint(assets, "upperleg01.L", body_cm);
  person.chin_cm = height_of_joint(assets, "neck03", body_cm);

  Part skin;
  skin.kind = PartKind::kSkin;
  skin.name = "skin";
  skin.mesh = std::shared_ptr<const Scan>(std::shared_ptr<void>(), &assets.base().mesh);
  skin.material = read_asset_material(assets.folder(), assets.folder() / recipe.skin);
  skin.rest_cm = body_cm;
  skin.bones = assets.skeleton().vertex_bones;
  skin.posed_cm = skinned(body_cm, skin.bones, person.motions);
  skin.faces = assets.base().skin_faces;
  person.parts.push_back(std::move(skin));

  put_on(assets, assets.eyes, PartKind::kEyes, body_cm, person);
  person.parts.back().material = read_asset_material(assets.folder(), assets.folder() / recipe.eye_material);
  for (const WornItem& item : person.recipe->clothes) {
    put_on(assets, item.file, PartKind::kClothes, body_cm, person);
    person.parts.back().worn = &item;
    if (!item.material.empty())
      person.parts.back().material = read_asset_material(assets.folder(), assets.folder() / item.material);
  }
  put_on(assets, recipe.hair, PartKind::kHair, body_cm, person);
  if (!recipe.brows.empty()) put_on(assets, recipe.brows, PartKind::kBrows, body_cm, person);
  return person;
}

std::vector<SurfaceTriangle> triangles_of(const Part& part) {
  std::vector<SurfaceTriangle> triangles;
  const Scan& mesh = *part.mesh;
  for (const uint32_t face : part.faces) {
    const uint32_t begin = mesh.face_begin[face], end = mesh.face_begin[face + 1];
    for (uint32_t c = begin + 1; c + 1 < end; ++c)
      triangles.push_back(
          {{mesh.corners[begin].position, mesh.corners[c].position, mesh.corners[c + 1].position}, face});
  }
  return triangles;
}

std::vector<Vec3f> normals_of(const Part& part, const std::vector<Vec3f>& positions) {
  std::vector<Vec3f> normals(positions.size());
  for (const SurfaceTriangle& triangle : triangles_of(part)) {
    const Vec3f a = positions[triangle.corner[0]];
    const Vec3f normal = cross(positions[triangle.corner[1]] - a, positions[triangle.corner[2]] - a);
    for (const uint32_t corner : triangle.corner) normals[corner] += normal;
  }
  for (Vec3f& normal : normals) normal = normalised(normal);
  return normals;
}

void stand_on_ground(Person& person) {
  Vec3f low{INFINITY, INFINITY, INFINITY}, high = -low;
  for (const Part& part : person.parts) {
    if (part.kind == PartKind::kBrows) continue;
    for (const SurfaceTriangle& triangle : triangles_of(part))
      for (const uint32_t corner : triangle.corner)
        for (int axis = 0; axis < 3; ++axis) {
          low[axis] = std::min(low[axis], part.posed_cm[corner][axis]);
          high[axis] = std::max(high[axis], part.posed_cm[corner][axis]);
        }
  }
  const Vec3f shift{-.5f * (low.x + high.x), -low.y, -.5f * (low.z + high.z)};
  for (Part& part : person.parts)
    for (Vec3f& position : part.posed_cm) position += shift;
}

}  // namespace ohb::people
