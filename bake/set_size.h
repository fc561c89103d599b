// How many texels the maps of a texture set have.
#pragma once

#include <cstddef>
#include <string>

#include "dataset/model/scan.h"

namespace ohb::bake {

struct MapSize {
  int width_px, height_px;
};

/// wanted_px along the longer edge (0: as many as the picture has), in the shape of the diffuse picture.
/// Without one: the source's edge (0: none), else kSizeWithoutPicture_px, more where colours at the vertices
/// of many triangles must be told apart. At most kMaxMapSize_px unless more are wanted.
MapSize size_of_set(const ScanMaterial& material, size_t triangles, int wanted_px, int source_edge_px);

/// As SetReport::mask_size.
std::string mask_size_of(const ScanMaterial& material);

}  // namespace ohb::bake
