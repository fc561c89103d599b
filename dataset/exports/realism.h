// The card's figure of what each step from a scan to a model of a person adds to a picture.
#pragma once

#include <string>
#include <vector>

#include "dataset/exports/sample_index.h"
#include "dataset/model/image.h"

namespace ohb::exports {

/// What the figure's columns show, in their order; each column is the whole person and the head.
const std::vector<std::string>& realism_steps();

struct RealismPictures {
  int size_px = 256;  // of each cell, width and height
  int spp = 16;       // paths a pixel
};

/// A row for each of three people, the first, middle and last of those whose model the dataset holds:
/// the scan as it came (its colours, Blender's default roughness and specular), with the classes' materials,
/// with light under the skin, with the surface's detail (the normal maps). Rendered under the bundled studio,
/// 32 paths a pixel, sRGB-encoded, clipped at 1. Empty if fewer than three
/// have a model. Equal models give equal bytes
/// for any number of threads. Throws as read_model and program_file; TryAgainError after a signal.
ByteImage realism_figure(const SampleIndex& index, const RealismPictures& pictures, bool quiet);

}  // namespace ohb::exports
