#include "learner/window.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "learner/hash.h"

namespace ohb::learner {
namespace {

constexpr double kCropped = 0.5, kLeastForeground = 0.1;
constexpr uint64_t kTries = 16;

/// The pixels that one average takes along an axis, and the part of each.
struct Span {
  int first = 0;
  std::vector<double> parts;
};

std::vector<Span> spans_of(int start_px, int side_px, int size_px) {
  std::vector<Span> spans(static_cast<size_t>(size_px));
  for (int64_t i = 0; i < size_px; ++i) {
    // In units of 1 / size_px of a pixel, so that whole factors stay exact.
    const int64_t low = i * side_px, high = low + side_px;
    Span& span = spans[static_cast<size_t>(i)];
    span.first = start_px + static_cast<int>(low / size_px);
    for (int64_t pixel = low / size_px; pixel * size_px < high; ++pixel)
      span.parts.push_back(
          static_cast<double>(std::min(high, (pixel + 1) * size_px) - std::max(low, pixel * size_px)) /
          size_px);
  }
  return spans;
}

double foreground_share(const Image& mask, const Window& window) {
  int64_t inside = 0;
  for (int y = window.top_px; y < window.top_px + window.side_px; ++y)
    for (int x = window.left_px; x < window.left_px + window.side_px; ++x) inside += *mask.pixel(x, y) > 0.5f;
  return static_cast<double>(inside) / (static_cast<double>(window.side_px) * window.side_px);
}

}  // namespace

Image averaged(const Image& image, const Image* weight, const Window& window, int size_px) {
  const auto columns = spans_of(window.left_px, window.side_px, size_px);
  const auto rows = spans_of(window.top_px, window.side_px, size_px);
  Image out(size_px, size_px, image.channels);
  for (int y = 0; y < size_px; ++y)
    for (int x = 0; x < size_px; ++x) {
      const Span &row = rows[static_cast<size_t>(y)], &column = columns[static_cast<size_t>(x)];
      double sum[4] = {}, total = 0;
      for (size_t j = 0; j < row.parts.size(); ++j)
        for (size_t i = 0; i < column.parts.size(); ++i) {
          const int px = column.first + static_cast<int>(i), py = row.first + static_cast<int>(j);
          const double w = row.parts[j] * column.parts[i] * (weight ? *weight->pixel(px, py) : 1);
          total += w;
          for (int c = 0; c < image.channels; ++c) sum[c] += w * image.pixel(px, py)[c];
        }
      for (int c = 0; c < image.channels; ++c)
        out.pixel(x, y)[c] = total > 0 ? static_cast<float>(sum[c] / total) : 0.0f;
    }
  return out;
}

Window drawn_window(const Image& mask, int size_px, uint64_t key) {
  const Window whole{0, 0, mask.width_px};
  uint64_t drawn = 0;
  const auto uniform = [&] { return uniform_of(key, drawn++); };
  if (uniform() >= kCropped) return whole;
  for (uint64_t i = 0; i < kTries; ++i) {
    Window window;
    const double zoom = std::pow(static_cast<double>(mask.width_px) / size_px, uniform());
    window.side_px = std::clamp(static_cast<int>(mask.width_px / zoom), size_px, mask.width_px);
    const int room = mask.width_px - window.side_px + 1;
    window.left_px = static_cast<int>(room * uniform());
    window.top_px = static_cast<int>(room * uniform());
    if (foreground_share(mask, window) >= kLeastForeground) return window;
  }
  return whole;
}

}  // namespace ohb::learner
