// A scan with its own materials, as the renderer can show them without any bake: what a bake is measured
// against.
#pragma once

#include "dataset/commands/bake_scan.h"

namespace ohb::commands {

/// The mesh as `bake` places it, each material's own pictures, and the values of the classes:
/// - with weights.exr in the regions, mixed by its shares at its own texels;
/// - without, a texture set for each material and class, so that the values change exactly at the faces'
///   edges.
/// Nothing is padded, mended or averaged, and the pictures are decoded apart from the bake's code. The maps
/// of a set have one size, that of the material's largest picture: smaller ones are looked up bilinearly at
/// its texels. Materials that classes split are named "<material>.<class>". Throws as canonical_mesh,
/// read_image.
Model source_material_model(const BakeInputs& inputs);

/// Texels along the longer edge of the scan's largest diffuse picture; kSizeWithoutPicture_px without one.
int largest_picture_px(const Scan& scan);

}  // namespace ohb::commands
