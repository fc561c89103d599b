// The fixed camera and the turntable.
#pragma once

#include "dataset/model/model.h"
#include "dataset/model/vec.h"

namespace ohb {

/// Looks along -Z from (0, center_y_cm, distance_cm), square image, pinhole. The subject turns, the camera
/// does not.
struct Camera {
  float center_y_cm = 0;
  float distance_cm = 0;  // from the world centre plane z = 0
  float half_width = 0;   // tangent of half the field of view
  /// Half the frame's width at the centre plane: the `r` that encodes displacement.
  float half_frame_cm() const { return distance_cm * half_width; }
};

/// 85 mm lens on a 36 mm sensor, as far away that the subject stays in frame at every turn, with 5 % margin
/// (computed from every vertex).
Camera fit_camera(const std::vector<Vec3f>& positions_cm);

constexpr float kLensMm = 85, kSensorMm = 36;

/// The subject's turn about +Y (right-handed: +Z goes towards +X) in view k of n, radians: 2 pi k / n.
double turn_of_view(int view, int view_count);
/// v turned by `angle` about +Y.
Vec3f turn_about_y(Vec3f v, double angle);

}  // namespace ohb
