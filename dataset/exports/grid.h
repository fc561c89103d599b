// Pictures in rows and columns.
#pragma once

#include <vector>

#include "dataset/model/image.h"

namespace ohb::exports {

/// The pictures (3 channels, 8 bits) row by row, each at the upper left of a cell as large as the largest of
/// them; black where there is none. Empty without pictures.
ByteImage grid_of(const std::vector<ByteImage>& pictures, int columns);

}  // namespace ohb::exports
