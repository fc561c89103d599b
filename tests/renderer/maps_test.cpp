// Material maps against an independent rasteriser: projected triangles, edge functions, a sorted list of
// layers a sample point, all in double and without rays.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "dataset/model/sampling.h"
#include "renderer/render.h"
#include "tests/support/test_models.h"

namespace ohb {
using namespace renderer;
namespace {

using Vec3d = std::array<double, 3>;

Image random_image(int size_px, int channels, uint64_t seed) {
  Image image(size_px, size_px, channels);
  Random random(seed, 0, 0);
  // Multiples of 1/256 are exact in half, so that texel precision is not part of the comparison.
  for (float& v : image.values) v = static_cast<float>(random.next_bits() % 256) / 256.0f;
  return image;
}

TextureSet random_set(uint64_t seed, bool cutout) {
  TextureSet set;
  set.name = "random" + std::to_string(seed);
  set.albedo = random_image(16, 3, seed);
  set.roughness = random_image(16, 1, seed + 1);
  set.specular = random_image(16, 1, seed + 2);
  set.sss = random_image(16, 1, seed + 3);
  set.displacement = random_image(16, 1, seed + 4);
  set.valid = random_image(16, 1, seed + 5);
  if (cutout) set.alpha = random_image(16, 1, seed + 6);
  return set;
}

// A lumpy sphere inside a ragged, partly transparent shell.
Model layered_model(uint64_t seed) {
  Model model = sphere_model(60, 24, random_set(seed, false));
  Random random(seed, 1, 1);
  for (Vec3f& p : model.positions_cm) {
    const Vec3f middle{0, 60, 0};
    p = middle + (0.8f + 0.4f * random.next()) * (p - middle);
  }
  model.sets.push_back(random_set(seed + 50, true));
  const uint32_t p0 = static_cast<uint32_t>(model.positions_cm.size()),
                 t0 = static_cast<uint32_t>(model.uvs.size());
  const size_t count = model.triangles.size();
  for (uint32_t i = 0; i < p0; ++i)
    model.positions_cm.push_back(Vec3f{0, 60, 0} + 1.3f * (model.positions_cm[i] - Vec3f{0, 60, 0}));
  for (uint32_t i = 0; i < t0; ++i)
    model.uvs.push_back(2.5f * model.uvs[i] - Vec2f{0.7f, 0.3f});  // wraps around
  for (size_t t = 0; t < count; t += 2) {
    ModelTriangle shell = model.triangles[t];
    for (int c = 0; c < 3; ++c) shell.position[c] += p0, shell.uv[c] += t0;
    shell.set = 1;
    shell.material_class = kHair;
    model.triangles.push_back(shell);
  }
  return model;
}

double bilinear(const Image& image, int channel, double u, double v) {
  const int n = image.width_px;
  const double x = (u - std::floor(u)) * n - 0.5, y = (1 - (v - std::floor(v))) * n - 0.5;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const double fx = x - x0, fy = y - y0;
  const auto at = [&](int i, int j) {
    return static_cast<double>(image.pixel(((i % n) + n) % n, ((j % n) + n) % n)[channel]);
  };
  return (at(x0, y0) * (1 - fx) + at(x0 + 1, y0) * fx) * (1 - fy) +
         (at(x0, y0 + 1) * (1 - fx) + at(x0 + 1, y0 + 1) * fx) * fy;
}

struct Layer {
  double depth, values[10],
      alpha;  // values: albedo 3, roughness, specular, sss, displacement, normal 3 (unit)
};

// Screen position in pixels and 1 / depth of a vertex.
Vec3d project(Vec3d world, const Camera& camera, int size_px) {
  const double depth = camera.distance_cm - world[2];
  const double scale = size_px / (2.0 * camera.half_width);
  return {size_px / 2.0 + world[0] / depth * scale,
          size_px / 2.0 - (world[1] - camera.center_y_cm) / depth * scale, 1 / depth};
}

class Rasteriser {
 public:
  Rasteriser(const Model& model, const Camera& camera, double turn, int size_px, int grid)
      : size_px_(size_px), grid_(grid), layers_(static_cast<size_t>(size_px) * size_px * grid * grid) {
    const std::vector<Vec3f> normals = smooth_normals(model);
    const double c = std::cos(turn), s = std::sin(turn);
    const auto turned = [&](Vec3f v) -> Vec3d { return {c * v.x + s * v.z, v.y, c * v.z - s * v.x}; };
    for (const ModelTriangle& t : model.triangles) {
      Vec3d p[3], n[3], q[3];
      for (int k = 0; k < 3; ++k) {
        p[k] = turned(model.positions_cm[t.position[k]]);
        n[k] = turned(normals[t.position[k]]);
        q[k] = project(p[k], camera, size_px);
      }
      draw(model, t, p, n, q, camera);
    }
    for (auto& list : layers_)
      std::sort(list.begin(), list.end(), [](const Layer& a, const Layer& b) { return a.depth < b.depth; });
  }

  // Mask and the ten values of a pixel, averaged over what covers it.
  std::array<double, 11> pixel(int x, int y) const {
    std::array<double, 11> out{};
    for (int j = 0; j < grid_; ++j)
      for (int i = 0; i < grid_; ++i) {
        double visible = 1;
        for (const Layer& layer : at(x * grid_ + i, y * grid_ + j)) {
          const double w = visible * layer.alpha;
          out[0] += w;
          for (int k = 0; k < 10; ++k) out[k + 1] += w * layer.values[k];
          visible *= 1 - layer.alpha;
        }
      }
    if (out[0] > 0)
      for (int k = 1; k < 11; ++k) out[k] /= out[0];
    const double length = std::sqrt(out[8] * out[8] + out[9] * out[9] + out[10] * out[10]);
    for (int k = 8; k < 11 && length > 0; ++k) out[k] /= length;
    out[0] /= grid_ * grid_;
    return out;
  }

 private:
  const std::vector<Layer>& at(int i, int j) const {
    return layers_[static_cast<size_t>(j) * size_px_ * grid_ + i];
  }

  void draw(const Model& model, const ModelTriangle& t, const Vec3d p[3], const Vec3d n[3], const Vec3d q[3],
            const Camera& camera) {
    const auto edge = [](const Vec3d& a, const Vec3d& b, double x, double y) {
      return (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
    };
    const double area = edge(q[0], q[1], q[2][0], q[2][1]);
    if (area == 0) return;
    const int n_points = size_px_ * grid_;
    const auto range = [&](int axis) {
      const double low = std::min({q[0][axis], q[1][axis], q[2][axis]}),
                   high = std::max({q[0][axis], q[1][axis], q[2][axis]});
      return std::pair<int, int>{std::max(0, static_cast<int>(std::floor(low * grid_ - 1))),
                                 std::min(n_points - 1, static_cast<int>(std::ceil(high * grid_ + 1)))};
    };
    const auto [x0, x1] = range(0);
    const auto [y0, y1] = range(1);
    for (int j = y0; j <= y1; ++j)
      for (int i = x0; i <= x1; ++i) {
        const double x = (i + 0.5) / grid_, y = (j + 0.5) / grid_;
        double w[3] = {edge(q[1], q[2], x, y) / area, edge(q[2], q[0], x, y) / area,
                       edge(q[0], q[1], x, y) / area};
        if (w[0] < 0 || w[1] < 0 || w[2] < 0) continue;
        double sum = 0;
        for (int k = 0; k < 3; ++k) sum += w[k] *= q[k][2];
        for (double& weight : w) weight /= sum;
        layers_[static_cast<size_t>(j) * n_points + i].push_back(
            shade(model, t, p, n, {w[0], w[1], w[2], 1 / sum}, camera));
      }
  }

  static Layer shade(const Model& model, const ModelTriangle& t, const Vec3d p[3], const Vec3d n[3],
                     const std::array<double, 4>& weights_and_depth, const Camera& camera) {
    const auto& [w0, w1, w2, depth] = weights_and_depth;
    const double w[3] = {w0, w1, w2};
    double u = 0, v = 0;
    Vec3d normal{}, place{};
    for (int k = 0; k < 3; ++k) {
      u += w[k] * model.uvs[t.uv[k]].x;
      v += w[k] * model.uvs[t.uv[k]].y;
      for (int a = 0; a < 3; ++a) normal[a] += w[k] * n[k][a], place[a] += w[k] * p[k][a];
    }
    const TextureSet& set = model.sets[t.set];
    // Turned to the side of the face that the camera sees.
    Vec3d e1, e2, to_camera{-place[0], camera.center_y_cm - place[1], camera.distance_cm - place[2]};
    for (int a = 0; a < 3; ++a) e1[a] = p[1][a] - p[0][a], e2[a] = p[2][a] - p[0][a];
    const Vec3d ng{e1[1] * e2[2] - e1[2] * e2[1], e1[2] * e2[0] - e1[0] * e2[2],
                   e1[0] * e2[1] - e1[1] * e2[0]};
    const double side = ng[0] * to_camera[0] + ng[1] * to_camera[1] + ng[2] * to_camera[2] < 0 ? -1 : 1;
    const double length = std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    Layer layer;
    layer.depth = depth;
    layer.alpha = set.alpha.values.empty() ? 1 : bilinear(set.alpha, 0, u, v);
    for (int c = 0; c < 3; ++c) layer.values[c] = bilinear(set.albedo, c, u, v);
    layer.values[3] = bilinear(set.roughness, 0, u, v);
    layer.values[4] = bilinear(set.specular, 0, u, v);
    layer.values[5] = bilinear(set.sss, 0, u, v);
    layer.values[6] = place[2];
    for (int a = 0; a < 3; ++a) layer.values[7 + a] = side * normal[a] / length;
    return layer;
  }

  int size_px_, grid_;
  std::vector<std::vector<Layer>> layers_;
};

TEST(MaterialMaps, EqualAnIndependentRasteriserOn20RandomViews) {
  constexpr int kSize = 48, kGrid = 4;
  Random random(77, 0, 0);
  size_t covered = 0, differing = 0;
  for (uint64_t view = 0; view < 20; ++view) {
    const Model model = layered_model(1000 + view);
    const auto scene = build_scene(model);
    const Camera camera = fit_camera(model.positions_cm);
    RenderSettings settings;
    settings.size_px = kSize;
    settings.map_grid = kGrid;
    const double turn = 6.28 * random.next();
    const Sample sample = render_maps(*scene, camera, turn, settings);
    // A subsurface texel below 0.01 says that light does not scatter (docs/conventions.md).
    Model stated = model;
    for (TextureSet& set : stated.sets)
      for (float& sss : set.sss.values) sss = sss < 0.01f ? 0 : sss;
    const Rasteriser expected(stated, camera, turn, kSize, kGrid);
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        const std::array<double, 11> e = expected.pixel(x, y);
        const float *d = sample.diffuse.pixel(x, y), *n = sample.normal.pixel(x, y);
        const double found[11] = {*sample.mask.pixel(x, y),
                                  d[0],
                                  d[1],
                                  d[2],
                                  *sample.roughness.pixel(x, y),
                                  *sample.specular.pixel(x, y),
                                  *sample.sss.pixel(x, y),
                                  *sample.displacement.pixel(x, y),
                                  n[0],
                                  n[1],
                                  n[2]};
        bool equal = true;
        // Displacement is in cm over a body of over 100 cm, the rest in [0,1].
        for (int k = 0; k < 11; ++k) equal &= std::fabs(found[k] - e[k]) < (k == 7 ? 2e-2 : 2e-3);
        covered += e[0] > 0;
        differing += !equal;
        if (e[0] > 0) {
          const float* c = sample.classes.pixel(x, y);
          EXPECT_NEAR(c[0] + c[1] + c[2] + c[3], 1, 1e-4);
        }
      }
  }
  EXPECT_GT(covered, 10000u);
  // Sample points within rounding of an edge fall on either side of it: 0.2 % of the pixels at most.
  EXPECT_LT(static_cast<double>(differing), 0.002 * static_cast<double>(covered))
      << differing << " of " << covered;
}

TEST(MaterialMaps, AreNeverMixedWithTheBackground) {
  TestMaterial material;
  material.roughness = 0.4f;
  const Model model = sphere_model(50, 48, constant_set(material));
  RenderSettings settings;
  settings.size_px = 40;
  const Sample sample = render_maps(*build_scene(model), fit_camera(model.positions_cm), 0, settings);
  size_t partly = 0;
  for (size_t i = 0; i < sample.mask.values.size(); ++i) {
    const float mask = sample.mask.values[i];
    partly += mask > 0 && mask < 1;
    if (mask > 0)
      EXPECT_NEAR(sample.roughness.values[i], 0.4f, 5e-4);
    else
      EXPECT_EQ(sample.roughness.values[i], 0);
  }
  EXPECT_GT(partly, 50u);
}

}  // namespace
}  // namespace ohb
