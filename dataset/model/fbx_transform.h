// Properties of FBX objects and the transforms that they make.
#pragma once

#include <array>
#include <string_view>

#include "dataset/model/affine.h"
#include "dataset/model/fbx_file.h"

namespace ohb {

/// An object's "Properties70" ("Properties60" in version 6) by name; absent ones take the value that
/// `defaults` (a property template of the file, or null) gives, else that of the caller.
class FbxProperties {
 public:
  FbxProperties(const FbxFile& file, const FbxNode& object, const FbxNode* defaults = nullptr)
      : file_(file), list_(list_of(object)), defaults_(defaults ? list_of(*defaults) : nullptr) {}

  /// Throw InputError if the property is there and no number.
  double number(std::string_view name, double missing) const;
  std::array<double, 3> vector(std::string_view name, std::array<double, 3> missing) const;

 private:
  static const FbxNode* list_of(const FbxNode& object);
  const FbxNode* find(std::string_view name) const;
  /// "name", "type", "label" (not in version 6), "flags", values...
  size_t first_value() const { return file_.version() < 7000 ? 3 : 4; }

  const FbxFile& file_;
  const FbxNode *list_, *defaults_;
};

/// A model's transform into its parent (FBX SDK: T Roff Rp Rpre R Rpost^-1 Rp^-1 Soff Sp S Sp^-1).
Affine fbx_local_transform(const FbxProperties& model);
/// What applies to the model's mesh only, not to its children.
Affine fbx_geometric_transform(const FbxProperties& model);

}  // namespace ohb
