#include "renderer/validation/focus.h"

#include <algorithm>
#include <cmath>

namespace ohb::validation {
namespace {

constexpr int kCell_px = 8;
constexpr double kTimeOfPath = 2;  // ours in Cycles' (one to three where measured: ours splits)

bool overlap(const renderer::PixelBox& a, const renderer::PixelBox& b) {
  return a.x0 < b.x1 && b.x0 < a.x1 && a.y0 < b.y1 && b.y0 < a.y1;
}

renderer::PixelBox joined(const renderer::PixelBox& a, const renderer::PixelBox& b) {
  return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

/// The tight box of the weighted pixels of each cell that has some.
std::vector<renderer::PixelBox> cell_boxes(const std::vector<float>& weights, int width, int height) {
  const int columns = (width + kCell_px - 1) / kCell_px, rows = (height + kCell_px - 1) / kCell_px;
  std::vector<renderer::PixelBox> cells(static_cast<size_t>(columns) * rows);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (!(weights[static_cast<size_t>(y) * width + x] > 0)) continue;
      renderer::PixelBox& cell = cells[static_cast<size_t>(y / kCell_px) * columns + x / kCell_px];
      const renderer::PixelBox pixel{x, y, x + 1, y + 1};
      cell = cell.x1 > cell.x0 ? joined(cell, pixel) : pixel;
    }
  cells.erase(
      std::remove_if(cells.begin(), cells.end(), [](const renderer::PixelBox& b) { return b.x1 <= b.x0; }),
      cells.end());
  return cells;
}

/// Whether two boxes are so close that they belong to one group.
bool adjacent(const renderer::PixelBox& a, const renderer::PixelBox& b) {
  return overlap({a.x0 - kCell_px, a.y0 - kCell_px, a.x1 + kCell_px, a.y1 + kCell_px}, b);
}

}  // namespace

std::vector<renderer::PixelBox> boxes_around(const std::vector<float>& weights, int width_px, int height_px) {
  std::vector<renderer::PixelBox> boxes;
  for (renderer::PixelBox box : cell_boxes(weights, width_px, height_px)) {
    // A larger box may touch more: until nothing does.
    for (auto touching = boxes.begin(); touching != boxes.end();) {
      if (!adjacent(*touching, box)) {
        ++touching;
        continue;
      }
      box = joined(*touching, box);
      boxes.erase(touching);
      touching = boxes.begin();
    }
    boxes.push_back(box);
  }
  return boxes;
}

std::optional<SidesWork> more_work(const Interval& ratio, const SidesWork& first, double target, double most,
                                   int max_spp) {
  const double half_width = 0.5 * (ratio.high - ratio.low);
  const double factor = half_width * half_width / (target * target);
  if (!(factor > 1)) return std::nullopt;
  const double first_share = static_cast<double>(first.our_spp) / first.cycles_spp;
  // The spread of a few seeds tells noise roughly: within limits.
  const double noise = ratio.share_a * first_share / std::max(1 - ratio.share_a, 1e-6);
  const double our_share = std::clamp(std::sqrt(noise / kTimeOfPath), 1.0 / 16, 1.0);
  const double more = factor * (1 - ratio.share_a + ratio.share_a * first_share / our_share);
  // Where Cycles may not get what it needs, ours still does.
  const double before = static_cast<double>(first.cycles_spp) * first.seeds;
  const double paths = std::min(more, most) * before;
  const double our_paths = std::min(our_share * more, most * first_share) * before;
  SidesWork work;
  work.seeds = std::max(first.seeds, static_cast<int>(std::ceil(paths / max_spp)));
  work.cycles_spp = std::min(max_spp, static_cast<int>(std::ceil(paths / work.seeds)));
  work.our_spp = static_cast<int>(std::ceil(our_paths / work.seeds));
  return work;
}

}  // namespace ohb::validation
