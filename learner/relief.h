// Maps of a picture as a surface that the path tracer renders: what the camera saw of the person.
#pragma once

#include "dataset/model/camera.h"
#include "dataset/model/model.h"
#include "learner/maps.h"

namespace ohb::learner {

/// Neighbouring pixels that differ by more are not joined, as in the Blender add-on (services/grid.py).
constexpr float kDepthJump_cm = 5;

/// One vertex a pixel, on the ray of the pixel's centre at its displacement, with the map's normal, and one
/// texel a pixel. Where the four pixels around a corner differ in depth by more than `jump_cm`, each keeps
/// its quarter of the square between them at its own depth: no sheet is drawn across, and no crack shows.
/// Pixels beside the outline repeat the nearest covered one, so that covered pixels are filled. Pits of up to
/// 2 pixels across that are deeper than 1 cm are filled: they are averages of near and far, where nothing is.
///
/// `maps` and `mask` are one picture, (1, C, N, N) of any floating type; displacement x half_frame_cm is in
/// cm. Pixels where the mask is 0 or a map is not finite are left out. Without any the model has no
/// triangles. World axes (docs/conventions.md), turn 0.
Model relief_of(const MaterialMaps& maps, const torch::Tensor& mask, const Camera& camera,
                float half_frame_cm, float jump_cm = kDepthJump_cm);

/// (1, 1, N, N) of bool: pixels of which something is covered and every map is finite.
torch::Tensor known_pixels(const MaterialMaps& maps, const torch::Tensor& mask);

}  // namespace ohb::learner
