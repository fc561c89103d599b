// A person as parts: body, eyes, clothes and hair, morphed, dressed and posed.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dataset/model/regions.h"
#include "dataset/people/recipe.h"
#include "dataset/people/surface_query.h"

namespace ohb::people {

enum class PartKind { kSkin, kEyes, kHair, kBrows, kClothes };

struct Part {
  PartKind kind = PartKind::kClothes;
  std::string name;
  std::shared_ptr<const Scan> mesh;  // faces and UVs; its positions are of another body
  AssetMaterial material;
  const WornItem* worn = nullptr;          // of the recipe, for clothes
  std::shared_ptr<const Garment> garment;  // null for the skin
  std::vector<Vec3f> rest_cm, posed_cm;    // one a position of the mesh
  std::vector<VertexBones> bones;
  std::vector<uint32_t> faces;  // of the mesh, that are kept
};

struct Person {
  std::shared_ptr<const Recipe> recipe;
  std::vector<Part> parts;         // skin, eyes, clothes from the inside out, hair, brows
  float hips_cm = 0, chin_cm = 0;  // heights in the rest pose
  std::vector<Affine> motions;     // of the bones

  const Part& skin() const { return parts[0]; }
};

/// Body, clothes, hair, eyes and brows in rest and pose, before anything is settled or hidden. Centimetres,
/// in MakeHuman's place. Throws InputError for an asset that cannot be read.
Person dress_person(const Assets& assets, const Recipe& recipe);

/// Unit normals at the positions, the mean of the kept faces' by area.
std::vector<Vec3f> normals_of(const Part& part, const std::vector<Vec3f>& positions);

/// Triangles of the part's kept faces (quads split), with the number of each one's face in the mesh.
std::vector<SurfaceTriangle> triangles_of(const Part& part);

/// Stands the person on y = 0, the middle of its bounding box at x = z = 0.
void stand_on_ground(Person& person);

}  // namespace ohb::people
