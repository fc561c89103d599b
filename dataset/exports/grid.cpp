#include "dataset/exports/grid.h"

#include <algorithm>

namespace ohb::exports {

ByteImage grid_of(const std::vector<ByteImage>& pictures, int columns) {
  int cell_width = 0, cell_height = 0;
  for (const ByteImage& picture : pictures) {
    cell_width = std::max(cell_width, picture.width_px);
    cell_height = std::max(cell_height, picture.height_px);
  }
  const int count = static_cast<int>(pictures.size());
  columns = std::max(1, columns);
  ByteImage grid(std::min(columns, count) * cell_width, (count + columns - 1) / columns * cell_height, 3);
  for (int i = 0; i < count; ++i) {
    const ByteImage& picture = pictures[static_cast<size_t>(i)];
    const int left = i % columns * cell_width, top = i / columns * cell_height;
    for (int y = 0; y < picture.height_px; ++y)
      std::copy_n(&picture.values[3 * static_cast<size_t>(y) * static_cast<size_t>(picture.width_px)],
                  3 * picture.width_px,
                  &grid.values[3 * (static_cast<size_t>(top + y) * static_cast<size_t>(grid.width_px) +
                                    static_cast<size_t>(left))]);
  }
  return grid;
}

}  // namespace ohb::exports
