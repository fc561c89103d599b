#include "renderer/lights.h"

#include <cmath>

#include "dataset/model/parallel.h"
#include "renderer/cycles_model.h"
#include "renderer/eight.h"

namespace ohb::renderer {
namespace {

// i in [-1, n] into [0, n).
int wrapped(int i, int n) {
  return i < 0 ? i + n : i >= n ? i - n : i;
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
  columns_.resize(height_px_);
  std::vector<double> row_weights(height_px_);
  parallel_for_each(0, height_px_, [&](int y) {
    const double sine = std::sin(kPi * (y + 0.5) / height_px_);
    std::vector<double> weights(width_px_);
    for (int x = 0; x < width_px_; ++x) {
      const size_t i = static_cast<size_t>(y) * width_px_ + x;
      texels_[i].radiance = {v[3 * i], v[3 * i + 1], v[3 * i + 2]};
      weights[x] = mean(texels_[i].radiance);
      texels_[i].density = static_cast<float>(weights[x] * sine);
    }
    columns_[y] = PiecewiseConstant(weights);
    row_weights[y] = columns_[y].total() * sine;
  });
  rows_ = PiecewiseConstant(row_weights);
  // Density per (u, v), then per solid angle: du dv = domega / (2 pi^2 sin theta).
  const double cells = static_cast<double>(width_px_) * height_px_;
  const double scale = rows_.total() > 0 ? cells / (rows_.total() * 2 * M_PI * M_PI) : 0;
  for (Texel& texel : texels_) texel.density *= static_cast<float>(scale);
}

MapPlace map_place(Vec3f direction) {
  const float sin_theta = std::sqrt(direction.x * direction.x + direction.z * direction.z);
  // environment_uv(direction)
  return {{0.5f + turns_of(direction.z, direction.x), 2 * turns_of(sin_theta, direction.y)}, sin_theta};
}

EnvironmentLight::Gather EnvironmentLight::gather(Vec2f uv) const {
  const float x = uv.x * static_cast<float>(width_px_) - 0.5f,
              y = uv.y * static_cast<float>(height_px_) - 0.5f;
  const float x0f = std::floor(x), y0f = std::floor(y);
  const int x0 = wrapped(static_cast<int>(x0f), width_px_),
            x1 = wrapped(static_cast<int>(x0f) + 1, width_px_);
  int y0 = static_cast<int>(y0f), y1 = y0 + 1;
  if (cycles::kEnvironmentWrapsPoles)
    y0 = wrapped(y0, height_px_), y1 = wrapped(y1, height_px_);
  else
    y0 = std::max(y0, 0), y1 = std::min(y1, height_px_ - 1);
  return {&texels_[static_cast<size_t>(y0) * width_px_],
          &texels_[static_cast<size_t>(y1) * width_px_],
          x0,
          x1,
          x - x0f,
          y - y0f};
}

void EnvironmentLight::prefetch(MapPlace place) const {
  const Gather g = gather(place.uv);
  __builtin_prefetch(&g.row0[g.x0]);
  __builtin_prefetch(&g.row1[g.x0]);
}

EnvironmentValue EnvironmentLight::at(MapPlace place) const {
  const Gather g = gather(place.uv);
  const auto four = [](const Texel& texel) { return same_bits<Float4>(texel); };
  const Float4 row0 = four(g.row0[g.x0]) + g.fx * (four(g.row0[g.x1]) - four(g.row0[g.x0])),
               row1 = four(g.row1[g.x0]) + g.fx * (four(g.row1[g.x1]) - four(g.row1[g.x0]));
  const Texel texel = same_bits<Texel>(row0 + g.fy * (row1 - row0));
  return {texel.radiance, texel.density / std::max(place.sin_theta, 1e-6f)};
}

LightSample EnvironmentLight::sample(float u1, float u2) const {
  float rest_x, rest_y;
  const int y = rows_.sample(u1, rest_y);
  const int x = columns_[y].sample(u2, rest_x);
  Vec2f uv{(static_cast<float>(x) + 0.5f + sample_tent(rest_x)) / static_cast<float>(width_px_),
           (static_cast<float>(y) + 0.5f + sample_tent(rest_y)) / static_cast<float>(height_px_)};
  // Half a tent hangs over the border: on the other side of the map, as in the lookup.
  uv = {uv.x - std::floor(uv.x), uv.y - std::floor(uv.y)};
  LightSample sample;
  const SineCosine phi = ohb::sine_cosine_of_turns(uv.x - 0.5f),
                   theta = ohb::sine_cosine_of_turns(0.5f * uv.y);
  sample.wi = {theta.sine * phi.cosine, theta.cosine, theta.sine * phi.sine};  // environment_direction(uv)
  const EnvironmentValue value = at(MapPlace{uv, theta.sine});
  sample.pdf = value.pdf;
  sample.radiance = value.radiance;
  return sample;
}

void LightPool::fill(const EnvironmentLight& light, double turn_rad, int columns_log2, int rows_log2,
                     uint64_t key, bool with_cells) {
  const int columns = 1 << columns_log2, rows = 1 << rows_log2;
  const int groups = columns / LightCandidates::kCount;  // a row
  columns_ = groups, rows_ = rows;
  groups_.resize(static_cast<size_t>(groups) * rows);
  const Vec3f turn_x = turn_about_y({1, 0, 0}, -turn_rad), turn_z = turn_about_y({0, 0, 1}, -turn_rad);
  Random random(key, 0, 0);
  // Along the rows of the map: their tables are then still in the cache.
  for (int x = 0; x < columns; ++x)
    for (int y = 0; y < rows; ++y) {
      const float u1 = (static_cast<float>(x) + random.next()) / static_cast<float>(columns);
      const float u2 = (static_cast<float>(y) + random.next()) / static_cast<float>(rows);
      const LightSample sample = light.sample(u1, u2);
      const Vec3f wi = sample.wi.x * turn_x + Vec3f{0, sample.wi.y, 0} + sample.wi.z * turn_z;
      const bool shines = sample.pdf > 0 && max_component(sample.radiance) > 0;
      // Members lie even along the columns, and along the rows by the golden section.
      const int k = x / groups, shift = static_cast<int>(fraction_of(kLatticeStep * k) * rows);
      const int row = (y - shift + rows) % rows;
      groups_[static_cast<size_t>(row) * groups + x % groups].set(
          k, wi, sample.radiance, shines ? sample.pdf : 0, with_cells ? DirectionCells::cell_of(wi) : 0);
    }
}

std::shared_ptr<const LightSet> prepare_lights(const std::vector<Environment>& environments,
                                               const std::vector<PointLight>& points) {
  auto lights = std::make_shared<LightSet>();
  lights->environments.reserve(environments.size());
  for (const Environment& environment : environments) lights->environments.emplace_back(environment);
  lights->points = points;
  return lights;
}

}  // namespace ohb::renderer
