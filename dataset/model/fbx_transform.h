// Properties of FBX objects and the transforms that they make.
#pragma once

#include <array>
#include <string_view>

#include "dataset/model/affine.h"
#include "dataset/model/fbx_file.h"

namespace ohb {

/// An object's "Properties70" by name; absent ones take the value the caller gives.
class FbxProperties {
 public:
  FbxProperties(const FbxFile& file, const FbxNode& object)
      : file_(file), list_(object.child("Properties70")) {}

  /// Throw InputError if the property is there and no number.
  double number(std::string_view name, double missing) const;
  std::array<double, 3> vector(std::string_view name, std::array<double, 3> missing) const;

 private:
  const FbxNode* find(std::string_view name) const;

  const FbxFile& file_;
  const FbxNode* list_;
};

/// A model's transform into its parent (FBX SDK: T Roff Rp Rpre R Rpost^-1 Rp^-1 Soff Sp S Sp^-1).
Affine fbx_local_transform(const FbxProperties& model);
/// What applies to the model's mesh only, not to its children.
Affine fbx_geometric_transform(const FbxProperties& model);

}  // namespace ohb
