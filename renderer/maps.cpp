// Material maps of a view: what the camera sees of the model's maps, averaged over what covers each pixel.

#include "dataset/model/parallel.h"
#include "dataset/model/regions.h"
#include "renderer/footprint.h"

namespace ohb::renderer {
namespace {

// Weighted sums of one pixel.
struct PixelSums {
  float weight = 0;
  Vec3f normal, albedo;
  std::array<float, kMaterialMaps.size()> materials{};
  float displacement = 0;
  float classes[kClassCount] = {};
};

// The subject as one camera sees it.
struct Look {
  const Scene& scene;
  ViewCamera view;
  double turn_rad;
};

void add_layer(const Look& look, const Ray& ray, const Hit& hit, float weight, PixelSums& sums) {
  const SurfacePoint point = surface_at(look.scene, hit, -ray.direction);
  sums.weight += weight;
  sums.normal += weight * look.view.to_camera(point.n);
  sums.albedo += weight * point.texel.albedo;
  for (size_t m = 0; m < kTexelValues.size(); ++m) sums.materials[m] += weight * point.texel.*kTexelValues[m];
  sums.displacement += weight * turn_about_y(point.position, look.turn_rad).z;
  if (point.material_class < kClassCount) sums.classes[point.material_class] += weight;
}

// All layers along a ray, front to back, until nothing more can be seen.
void add_point(const Look& look, const Ray& ray, PixelSums& sums) {
  const Scene& scene = look.scene;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Hit solid, layer;
  const bool has_solid = scene.opaque && intersect_bvh(scene.opaque, 0, ray, 0, kInfinity, solid);
  float visible = 1, t_near = 0;
  uint32_t passed = surface::kNoTriangle;
  const float t_far = has_solid ? solid.t : kInfinity;
  while (scene.cutout && visible > 0 &&
         intersect_bvh(scene.cutout, scene.opaque_count, ray, t_near, t_far, layer)) {
    const float alpha = layer.triangle == passed ? 0 : std::clamp(alpha_at(scene, layer), 0.0f, 1.0f);
    if (alpha > 0) add_layer(look, ray, layer, visible * alpha, sums);
    visible *= 1 - alpha;
    passed = layer.triangle;
    t_near = surface::beyond(layer.t, t_near);
  }
  if (has_solid && visible > 0) add_layer(look, ray, solid, visible, sums);
}

void store(const PixelSums& sums, int points, int x, int y, Sample& sample) {
  *sample.mask.pixel(x, y) = std::fmin(1.0f, sums.weight / static_cast<float>(points));
  if (!(sums.weight > 0)) return;
  const float scale = 1 / sums.weight;
  const Vec3f n = normalised(sums.normal), albedo = sums.albedo * scale;
  float* normal = sample.normal.pixel(x, y);
  float* diffuse = sample.diffuse.pixel(x, y);
  for (int c = 0; c < 3; ++c) normal[c] = n[c], diffuse[c] = albedo[c];
  for (size_t m = 0; m < kMaterialMaps.size(); ++m)
    *(sample.*kMaterialMaps[m].pixels).pixel(x, y) = sums.materials[m] * scale;
  *sample.displacement.pixel(x, y) = sums.displacement * scale;
  for (int c = 0; c < kClassCount; ++c) sample.classes.pixel(x, y)[c] = sums.classes[c] * scale;
}

}  // namespace

Sample render_maps(const Scene& scene, const Camera& camera, double turn_rad, const RenderSettings& settings,
                   const PixelsDone& done) {
  const int n = settings.size_px, grid = settings.map_grid;
  Sample sample;
  for (const SampleMap& map : sample_maps())
    sample.*map.image = Image(n, n, static_cast<int>(map.channels.size()));
  const Look look{scene, ViewCamera(camera, turn_rad, n), turn_rad};
  const std::vector<uint8_t> seen = footprint(scene, look.view, n);
  parallel_for_each(0, n, [&](int y) {
    for (int x = 0; x < n; ++x) {
      if (!seen[static_cast<size_t>(y) * n + x]) continue;
      PixelSums sums;
      for (int j = 0; j < grid; ++j)
        for (int i = 0; i < grid; ++i) {
          const float step = 1 / static_cast<float>(grid);
          const Ray ray = look.view.ray(static_cast<float>(x) + (static_cast<float>(i) + 0.5f) * step,
                                        static_cast<float>(y) + (static_cast<float>(j) + 0.5f) * step);
          add_point(look, ray, sums);
        }
      store(sums, grid * grid, x, y, sample);
    }
    if (done) done(static_cast<size_t>(n));
  });
  return sample;
}

}  // namespace ohb::renderer
