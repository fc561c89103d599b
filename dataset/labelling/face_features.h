// What labelling knows of each face: its shape, its colour, and how strongly it differs from its neighbours.
#pragma once

#include <vector>

#include "dataset/labelling/alpha_expansion.h"
#include "dataset/labelling/colour_model.h"
#include "dataset/labelling/face_colours.h"
#include "dataset/labelling/face_graph.h"

namespace ohb::labelling {

/// Radius of the surroundings whose texture counts as a face's own.
constexpr double kTextureRadius_cm = 1.5;

struct FaceFeatures {
  FaceGraph graph;
  std::vector<Vec3f> lab;                      // mean of the face's texels
  std::vector<Vec3f> spread;                   // their standard deviation
  std::vector<Vec3f> local_lab, local_spread;  // the same of all texels within kTextureRadius_cm
  std::vector<Appearance> appearance;

  size_t size() const { return graph.size(); }
};

/// Throws InputError for a picture that cannot be read.
FaceFeatures face_features(const ScanSurface& surface);

/// How alike the two faces of each edge are, in (kLeastLikeness, 1]: exp(-dE^2 / 2 s^2) of their colours, s
/// the median difference and the texture of both, less across creases and bridges. One number an edge of the
/// graph.
std::vector<float> edge_likeness(const FaceFeatures& features);
constexpr float kLeastLikeness = 0.02f;

/// The median of colour differences, and no less than what the eye takes for one colour (2 of CIE 1976).
float median_difference(std::vector<float> differences);

}  // namespace ohb::labelling
