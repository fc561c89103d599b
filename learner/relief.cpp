#include "learner/relief.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "dataset/model/regions.h"

namespace ohb::learner {
namespace {

using torch::Tensor;

constexpr int kNowhere = -1;
constexpr float kSteepest =
    4;  // depth over width beyond the outline, where normals are at their least certain

constexpr int kPitPx = 2;    // pits of at most so many pixels across are mended ...
constexpr float kPitCm = 1;  // ... that are deeper than this

struct Place {
  int x = 0, y = 0;
};

/// The eight neighbours, the nearer ones first.
constexpr std::array<Place, 8> kAround = {
    {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}}};

/// Planes of floats over N x N pixels.
class Planes {
 public:
  explicit Planes(const Tensor& map)
      : values_(map.detach().to(torch::kCPU, torch::kFloat).contiguous()), pixels_(map[0][0].numel()) {}
  float at(int64_t channel, int64_t pixel) const {
    return values_.data_ptr<float>()[channel * pixels_ + pixel];
  }
  Vec3f vector_at(int64_t pixel) const { return {at(0, pixel), at(1, pixel), at(2, pixel)}; }

 private:
  Tensor values_;
  int64_t pixels_;
};

/// For each pixel the one whose values it shows: itself if known, a known neighbour beside the outline, or
/// kNowhere.
std::vector<int> sources_of(const Tensor& known, int n) {
  const Tensor flat = known.contiguous();
  const bool* is_known = flat.data_ptr<bool>();
  std::vector<int> sources(static_cast<size_t>(n) * n, kNowhere);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      int& source = sources[static_cast<size_t>(y) * n + x];
      if (is_known[y * n + x]) source = y * n + x;
      for (const Place step : kAround) {
        const int i = x + step.x, j = y + step.y;
        if (source == kNowhere && i >= 0 && j >= 0 && i < n && j < n && is_known[j * n + i])
          source = j * n + i;
      }
    }
  return sources;
}

/// Morphological closing of depths by a segment of kPitPx + 1 pixels in one direction: the lowest of the
/// segments through a pixel, each counting as its highest known pixel.
float closed_depth(const std::vector<float>& depths_cm, const bool* known, int n, int pixel, Place step) {
  const int x = pixel % n, y = pixel / n;
  float lowest = INFINITY;
  for (int first = -kPitPx; first <= 0; ++first) {
    float highest = -INFINITY;
    for (int k = first; k <= first + kPitPx; ++k) {
      const int i = x + k * step.x, j = y + k * step.y;
      if (i >= 0 && j >= 0 && i < n && j < n && known[j * n + i])
        highest = std::max(highest, depths_cm[static_cast<size_t>(j * n + i)]);
    }
    lowest = std::min(lowest, highest);
  }
  return lowest;
}

/// Fills isolated pits. A pixel on an edge holds the mean of near and far, where nothing is (the corner of a
/// mouth, a gap between strands of hair): a hole there is black under any light. A pit is closed in along
/// rows, columns and both diagonals, so slopes, steps, creases and the person's outline stay. The same as
/// mend_pits in blender_addon's decode.py.
std::vector<float> without_pits(const std::vector<float>& depths_cm, const Tensor& known, int n) {
  constexpr std::array<Place, 4> kLines = {{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};
  const Tensor flat = known.contiguous();
  const bool* is_known = flat.data_ptr<bool>();
  std::vector<float> mended = depths_cm;
  for (int p = 0; p < n * n; ++p) {
    if (!is_known[p]) continue;
    float level = INFINITY;
    for (const Place line : kLines) level = std::min(level, closed_depth(depths_cm, is_known, n, p, line));
    if (level > depths_cm[static_cast<size_t>(p)] + kPitCm) mended[static_cast<size_t>(p)] = level;
  }
  return mended;
}

/// Depth of each pixel in cm, without pits.
std::vector<float> depths_of(const MaterialMaps& maps, const Tensor& known, float half_frame_cm) {
  const Planes displacement(maps.displacement);
  const int n = static_cast<int>(maps.normal.size(3));
  std::vector<float> depths_cm(static_cast<size_t>(n) * n);
  for (int p = 0; p < n * n; ++p) depths_cm[static_cast<size_t>(p)] = half_frame_cm * displacement.at(0, p);
  return without_pits(depths_cm, known, n);
}

class ReliefBuilder {
 public:
  /// depths_cm: of each pixel; sources: as sources_of gives them.
  ReliefBuilder(const Tensor& normals, const Camera& camera, float half_frame_cm, float jump_cm,
                const std::vector<float>& depths_cm, std::vector<int> sources)
      : camera_(camera),
        size_px_(static_cast<int>(normals.size(3))),
        jump_cm_(jump_cm),
        normals_(normals),
        sources_(std::move(sources)),
        vertices_(sources_.size(), 0) {
    const float pixel_cm = 2 * half_frame_cm / static_cast<float>(size_px_);
    for (int p = 0; p < size_px_ * size_px_; ++p) {
      const int source = sources_[static_cast<size_t>(p)];
      depths_cm_.push_back(source == kNowhere ? 0
                                              : depths_cm[static_cast<size_t>(source)] +
                                                    pixel_cm * slope_between(source, p));
    }
  }

  /// All but the texture set; called once.
  Model build() {
    for (int p = 0; p < size_px_ * size_px_; ++p)
      if (sources_[static_cast<size_t>(p)] != kNowhere)
        vertices_[static_cast<size_t>(p)] =
            add_vertex(static_cast<float>(place_of(p).x) + 0.5f, static_cast<float>(place_of(p).y) + 0.5f, p);
    for (int y = 0; y + 1 < size_px_; ++y)
      for (int x = 0; x + 1 < size_px_; ++x) add_square(y * size_px_ + x);
    return std::move(model_);
  }

 private:
  /// How much nearer the tangent plane of a pixel is at another one, in widths of a pixel: the surface goes
  /// on behind the outline, where light from the side passes it.
  float slope_between(int pixel, int other) const {
    const Place from = place_of(pixel), to = place_of(other);
    if (pixel == other) return 0;
    const Vec3f n = normals_.vector_at(pixel);
    const float across = n.x * static_cast<float>(to.x - from.x) + n.y * static_cast<float>(from.y - to.y);
    return std::clamp(-across / std::max(n.z, 1e-3f), -kSteepest, kSteepest);
  }

  Place place_of(int pixel) const { return {pixel % size_px_, pixel / size_px_}; }

  /// At image coordinates in pixels, (0, 0) the top left corner, with the depth and values of a pixel.
  uint32_t add_vertex(float x, float y, int pixel) {
    const float z = depths_cm_[static_cast<size_t>(pixel)], n = static_cast<float>(size_px_);
    const float scale = camera_.half_width * (camera_.distance_cm - z);
    model_.positions_cm.push_back(
        {(2 * x / n - 1) * scale, camera_.center_y_cm + (1 - 2 * y / n) * scale, z});
    const int source = sources_[static_cast<size_t>(pixel)];
    model_.normals.push_back(normalised(normals_.vector_at(source)));
    const Place texel = place_of(source);
    model_.uvs.push_back(
        {(static_cast<float>(texel.x) + 0.5f) / n, 1 - (static_cast<float>(texel.y) + 0.5f) / n});
    return static_cast<uint32_t>(model_.positions_cm.size() - 1);
  }

  /// Corners from the top left one, counter-clockwise to the viewer.
  void add_quad(uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    for (const auto& [i, j, k] : {std::array<uint32_t, 3>{a, b, c}, {a, c, d}})
      model_.triangles.push_back({{i, j, k}, {i, j, k}, 0, kSkin, 0});
  }

  /// The square between the centres of a pixel and its right and lower neighbours.
  void add_square(int pixel) {
    const std::array<int, 4> corners = {pixel, pixel + size_px_, pixel + size_px_ + 1, pixel + 1};
    float nearest = -INFINITY, farthest = INFINITY;
    for (const int corner : corners) {
      if (sources_[static_cast<size_t>(corner)] == kNowhere) return;
      nearest = std::max(nearest, depths_cm_[static_cast<size_t>(corner)]);
      farthest = std::min(farthest, depths_cm_[static_cast<size_t>(corner)]);
    }
    const auto vertex = [&](int corner) { return vertices_[static_cast<size_t>(corner)]; };
    if (nearest - farthest <= jump_cm_)
      return add_quad(vertex(corners[0]), vertex(corners[1]), vertex(corners[2]), vertex(corners[3]));
    const Place middle = {place_of(pixel).x + 1, place_of(pixel).y + 1};
    for (const int corner : corners) add_quarter(corner, middle);
  }

  /// From a pixel's centre half way to its neighbours, at the pixel's depth.
  void add_quarter(int pixel, Place middle) {
    const float x = static_cast<float>(place_of(pixel).x) + 0.5f, mx = static_cast<float>(middle.x);
    const float y = static_cast<float>(place_of(pixel).y) + 0.5f, my = static_cast<float>(middle.y);
    const float left = std::min(x, mx), right = std::max(x, mx);
    const float top = std::min(y, my), bottom = std::max(y, my);
    const uint32_t a = add_vertex(left, top, pixel), b = add_vertex(left, bottom, pixel);
    const uint32_t c = add_vertex(right, bottom, pixel), d = add_vertex(right, top, pixel);
    add_quad(a, b, c, d);
  }

  const Camera camera_;
  const int size_px_;
  const float jump_cm_;
  const Planes normals_;
  const std::vector<int> sources_;
  std::vector<uint32_t> vertices_;  // of the pixels' centres
  std::vector<float> depths_cm_;
  Model model_;
};

/// The maps as texels; 0 where `known` is not.
TextureSet texels_of(const MaterialMaps& maps, const Tensor& known) {
  const int n = static_cast<int>(maps.normal.size(3));
  const auto image = [&](const Tensor& map) {
    const Planes planes(torch::where(known, map, torch::zeros_like(map)));
    Image out(n, n, static_cast<int>(map.size(1)));
    for (int64_t p = 0; p < int64_t{n} * n; ++p)
      for (int c = 0; c < out.channels; ++c)
        out.values[static_cast<size_t>(p * out.channels + c)] = planes.at(c, p);
    return out;
  };
  TextureSet set;
  set.name = "maps";
  for (const LearnedMap& map : kMaps)
    if (map.texels) set.*map.texels = image(maps.*map.tensor);
  set.displacement = Image(n, n, 1);
  set.valid = image(known.to(torch::kFloat));
  return set;
}

}  // namespace

Tensor known_pixels(const MaterialMaps& maps, const Tensor& mask) {
  Tensor known = mask > 0;
  for (const LearnedMap& map : kMaps) known = known & torch::isfinite(maps.*map.tensor).all(1, true);
  return known;
}

Model relief_of(const MaterialMaps& maps, const Tensor& mask, const Camera& camera, float half_frame_cm,
                float jump_cm) {
  const Tensor known = known_pixels(maps, mask);
  std::vector<int> sources = sources_of(known, static_cast<int>(mask.size(3)));
  const std::vector<float> depths_cm = depths_of(maps, known, half_frame_cm);
  Model model =
      ReliefBuilder(maps.normal, camera, half_frame_cm, jump_cm, depths_cm, std::move(sources)).build();
  model.name = "relief";
  model.sets = {texels_of(maps, known)};
  return model;
}

}  // namespace ohb::learner
