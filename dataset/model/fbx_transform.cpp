#include "dataset/model/fbx_transform.h"

#include <cmath>

namespace ohb {
namespace {

using Triple = std::array<double, 3>;

Affine translation(const Triple& t, double sign = 1) {
  Affine a;
  for (int i = 0; i < 3; ++i) a(i, 3) = sign * t[static_cast<size_t>(i)];
  return a;
}

Affine scaling(const Triple& s) {
  Affine a;
  for (int i = 0; i < 3; ++i) a(i, i) = s[static_cast<size_t>(i)];
  return a;
}

Affine rotation_about(int axis, double degrees) {
  // Quarter turns are exact: exporters use them to change the up axis.
  const double quarters = degrees / 90;
  double c = std::cos(degrees * M_PI / 180), s = std::sin(degrees * M_PI / 180);
  if (quarters == std::round(quarters)) {
    c = std::round(c);
    s = std::round(s);
  }
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  Affine a;
  a(i, i) = c;
  a(i, j) = -s;
  a(j, i) = s;
  a(j, j) = c;
  return a;
}

/// Euler angles in degrees; `order` as FBX numbers it: 0 XYZ (X first), 1 XZY, 2 YZX, 3 YXZ, 4 ZXY, 5 ZYX.
Affine rotation(const Triple& degrees, double order = 0) {
  static constexpr int kAxes[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 2, 0}, {1, 0, 2}, {2, 0, 1}, {2, 1, 0}};
  Affine a;
  for (int axis : kAxes[order > 0 && order < 6 ? static_cast<int>(order) : 0])
    a = rotation_about(axis, degrees[static_cast<size_t>(axis)]) * a;
  return a;
}

/// The inverse of a rotation.
Affine transposed(const Affine& a) {
  Affine t;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) t(i, j) = a(j, i);
  return t;
}

}  // namespace

const FbxNode* FbxProperties::list_of(const FbxNode& object) {
  const FbxNode* list = object.child("Properties70");
  return list ? list : object.child("Properties60");
}

const FbxNode* FbxProperties::find(std::string_view name) const {
  for (const FbxNode* list : {list_, defaults_}) {
    if (!list) continue;
    for (const FbxNode& property : list->children)
      if (property.values.size() > first_value() && property.values[0].bytes == name) return &property;
  }
  return nullptr;
}

double FbxProperties::number(std::string_view name, double missing) const {
  const FbxNode* property = find(name);
  return property ? file_.number(*property, first_value()) : missing;
}

Triple FbxProperties::vector(std::string_view name, Triple missing) const {
  const FbxNode* property = find(name);
  if (!property) return missing;
  const size_t first = first_value();
  return {file_.number(*property, first), file_.number(*property, first + 1),
          file_.number(*property, first + 2)};
}

Affine fbx_local_transform(const FbxProperties& model) {
  const Triple zero{0, 0, 0}, one{1, 1, 1};
  const bool has_full_rotation = model.number("RotationActive", 1) != 0;
  const double order = has_full_rotation ? model.number("RotationOrder", 0) : 0;
  const Affine before = has_full_rotation ? rotation(model.vector("PreRotation", zero)) : Affine();
  const Affine after = has_full_rotation ? rotation(model.vector("PostRotation", zero)) : Affine();
  const Triple rotation_pivot = model.vector("RotationPivot", zero);
  const Triple scaling_pivot = model.vector("ScalingPivot", zero);
  return translation(model.vector("Lcl Translation", zero)) *
         translation(model.vector("RotationOffset", zero)) * translation(rotation_pivot) * before *
         rotation(model.vector("Lcl Rotation", zero), order) * transposed(after) *
         translation(rotation_pivot, -1) * translation(model.vector("ScalingOffset", zero)) *
         translation(scaling_pivot) * scaling(model.vector("Lcl Scaling", one)) *
         translation(scaling_pivot, -1);
}

Affine fbx_geometric_transform(const FbxProperties& model) {
  return translation(model.vector("GeometricTranslation", {0, 0, 0})) *
         rotation(model.vector("GeometricRotation", {0, 0, 0})) *
         scaling(model.vector("GeometricScaling", {1, 1, 1}));
}

}  // namespace ohb
