// Which pixels of a view can see anything at all.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/surface.h"

namespace ohb::renderer {

/// Pixels of a size_px x size_px image (row 0 at the top) that no ray hits anything in are 0; the others may
/// be 1 though they see nothing. Each triangle marks the box of its projected corners and a twentieth of a
/// pixel around it; a triangle that reaches behind the camera marks everything.
std::vector<uint8_t> footprint(const Scene& scene, const ViewCamera& view, int size_px);

}  // namespace ohb::renderer
