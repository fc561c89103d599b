#include "renderer/lights.h"

#include <cmath>

#include "renderer/cycles_model.h"

namespace ohb {
namespace {

// Radiance at texel (x, y), wrapped on both axes as Cycles does.
size_t wrapped(int x, int y, int width, int height) {
  x = (x + width) % width;
  y = cycles::kEnvironmentWrapsPoles ? (y + height) % height : std::clamp(y, 0, height - 1);
  return static_cast<size_t>(y) * width + x;
}

}  // namespace

PiecewiseConstant::PiecewiseConstant(const std::vector<double>& weights) {
  const size_t n = weights.size();
  for (const double weight : weights) total_ += weight;
  cdf_.assign(n + 1, 0.0f);
  double sum = 0;
  for (size_t i = 0; i < n; ++i) {
    // All weights zero: uniform, so that the table stays usable.
    sum += total_ > 0 ? weights[i] / total_ : 1.0 / static_cast<double>(n);
    cdf_[i + 1] = static_cast<float>(std::min(sum, 1.0));
  }
  cdf_[n] = 1;
  guide_.assign(n, 0);
  size_t cell = 0;
  for (size_t i = 0; i < n; ++i) {
    const float u = static_cast<float>(i) / static_cast<float>(n);
    while (cell + 1 < n && cdf_[cell + 1] <= u) ++cell;
    guide_[i] = static_cast<int>(cell);
  }
}

EnvironmentLight::EnvironmentLight(const Environment& environment)
    : name_(environment.name),
      width_px_(environment.radiance.width_px),
      height_px_(environment.radiance.height_px) {
  const std::vector<float>& v = environment.radiance.values;
  texels_.resize(v.size() / 3);
  for (size_t i = 0; i < texels_.size(); ++i) texels_[i] = {v[3 * i], v[3 * i + 1], v[3 * i + 2]};

  // The mean of the bilinear lookup over a cell: wherever light comes from, the pdf is above zero.
  static constexpr double kCellMean[3] = {0.125, 0.75, 0.125};
  std::vector<double> row_weights(height_px_);
  for (int y = 0; y < height_px_; ++y) {
    std::vector<double> weights(width_px_, 0.0);
    for (int x = 0; x < width_px_; ++x)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
          weights[x] += kCellMean[dx + 1] * kCellMean[dy + 1] *
                        mean(texels_[wrapped(x + dx, y + dy, width_px_, height_px_)]);
    columns_.emplace_back(weights);
    row_weights[y] = columns_.back().total() * std::sin(kPi * (y + 0.5) / height_px_);
  }
  rows_ = PiecewiseConstant(row_weights);
}

Vec3f EnvironmentLight::lookup(Vec2f uv) const {
  const float x = uv.x * static_cast<float>(width_px_) - 0.5f,
              y = uv.y * static_cast<float>(height_px_) - 0.5f;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
  const auto at = [&](int dx, int dy) { return texels_[wrapped(x0 + dx, y0 + dy, width_px_, height_px_)]; };
  return (1 - fy) * ((1 - fx) * at(0, 0) + fx * at(1, 0)) + fy * ((1 - fx) * at(0, 1) + fx * at(1, 1));
}

Vec3f EnvironmentLight::radiance(Vec3f direction) const {
  return lookup(environment_uv(direction));
}

// A cell is sampled uniformly in (u, v): density per solid angle = p n / (2 pi^2 sin theta).
float EnvironmentLight::pdf_of_cell(int x, int y, float sin_theta) const {
  const float cells = static_cast<float>(width_px_) * static_cast<float>(height_px_);
  return rows_.probability(y) * columns_[y].probability(x) * cells /
         (2 * kPi * kPi * std::fmax(sin_theta, 1e-6f));
}

float EnvironmentLight::pdf(Vec3f direction) const {
  const Vec2f uv = environment_uv(direction);
  const int x = std::clamp(static_cast<int>(uv.x * static_cast<float>(width_px_)), 0, width_px_ - 1);
  const int y = std::clamp(static_cast<int>(uv.y * static_cast<float>(height_px_)), 0, height_px_ - 1);
  return pdf_of_cell(x, y, std::hypot(direction.x, direction.z));
}

LightSample EnvironmentLight::sample(float u1, float u2) const {
  float rest_x, rest_y;
  const int y = rows_.sample(u1, rest_y);
  const int x = columns_[y].sample(u2, rest_x);
  const Vec2f uv{(static_cast<float>(x) + rest_x) / static_cast<float>(width_px_),
                 (static_cast<float>(y) + rest_y) / static_cast<float>(height_px_)};
  LightSample sample;
  sample.wi = environment_direction(uv);
  sample.pdf = pdf_of_cell(x, y, std::sin(kPi * uv.y));
  sample.radiance = lookup(uv);
  return sample;
}

std::shared_ptr<const LightSet> prepare_lights(const std::vector<Environment>& environments,
                                               const std::vector<PointLight>& points) {
  auto lights = std::make_shared<LightSet>();
  for (const Environment& environment : environments) lights->environments.emplace_back(environment);
  lights->points = points;
  return lights;
}

}  // namespace ohb
