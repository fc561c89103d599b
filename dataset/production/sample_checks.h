// What every sample of a dataset must hold, whoever is in it.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "dataset/model/material_table.h"
#include "dataset/model/sample.h"

namespace ohb::production {

/// What is wrong with the sample by itself, a line each, with the first pixel and how many: coverage outside
/// [0, 1]; normals that are not unit inside the mask; values outside [0, 1], and roughness, specular and sss
/// outside what the table's classes can mix to; shares of classes that do not add to 1; maps and lit images
/// that are not 0 outside the mask; displacement beyond the frame; lit images that are clearly negative, or
/// black everywhere; an empty mask.
std::vector<std::string> sample_faults(const Sample& sample, const MaterialTable& table);

/// Pixels in which each class is seen, weighted by coverage.
std::array<double, kClassCount> class_pixels(const Sample& sample);

/// What of a stored sample does not agree with the same view rendered anew, `a` and `b`, which differ in
/// their random numbers alone and have `spp` paths a pixel: maps must be equal but for single pixels, and
/// each light's image, averaged over an 8 x 8 grid, must lie within what the difference of a and b says of
/// noise. `stored_spp`: of the stored one; 0: at least as many.
std::vector<std::string> rerender_faults(const Sample& stored, const Sample& a, const Sample& b, int spp,
                                         int stored_spp);

}  // namespace ohb::production
