// The renderer's public face: from a model, lights and a camera to maps and radiance images.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "dataset/model/camera.h"
#include "dataset/model/environment.h"
#include "dataset/model/model.h"
#include "dataset/model/sample.h"

namespace ohb::renderer {

/// A light of no size in world space (it does not turn with the subject). `intensity` is radiant intensity
/// with distances in metres: the irradiance at d metres is intensity / d^2, in each of R, G, B.
struct PointLight {
  std::string name;
  Vec3f position_cm;
  float intensity = 1;
};

/// Pixels x0 <= x < x1, y0 <= y < y1, row 0 at the top.
struct PixelBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

/// How surfaces reflect: Blender's Principled BSDF as Cycles 3.4 has it (v1: diffuse and highlight added) or
/// as Cycles 4.5 has it (v2: layered, keeps energy). docs/conventions.md says what the maps mean to each.
enum class ShadingModel { kV1, kV2 };

struct RenderSettings {
  int size_px = 512;     // square image
  int spp = 256;         // paths a pixel, each serving every light
  uint64_t seed = 1;     // of this image; equal seeds give equal bits
  int max_bounces = 32;  // indirect generations; the last ray still sees the environments
  /// The last surface sends no such ray where it is rough: what it reflects is left to the lights' own
  /// directions. Unbiased but for highlights from below the smooth surface (bsdf.h); for previews and kAuto.
  bool ends_at_rough_surfaces = false;
  /// spp becomes the mean over the pixels that see something, spent where the noise is: least mean squared
  /// error for the work. Unbiased: an eighth of the paths are made first, and how many more a pixel gets is
  /// told from its neighbours' alone (continued_budget() in budget.h). From 16 on.
  bool adaptive = false;
  /// Fewer shadow rays to environments where earlier ones of neighbouring pixels tell what to expect
  /// (shadow_guess.h). Unbiased either way; single pixels of few paths may come out a little below 0.
  bool guess_shadows = true;
  ShadingModel shading = ShadingModel::kV1;
  bool subsurface = true;  // false: skin reflects diffusely instead
  int map_grid = 8;        // the maps average map_grid x map_grid points a pixel
  /// Cycles sends sample 0 of each pixel through the centre; set it to equal Cycles at the same spp.
  bool first_sample_at_centre = false;
  /// Only these pixels of the lights' images, the others stay 0; empty: all. Does not change what a pixel is.
  PixelBox crop{};
};

/// One query of a bounding volume hierarchy, for benchmarks that repeat it with bare Embree.
struct RecordedRay {
  Vec3f origin, direction;
  float t_near, t_far;
  bool is_shadow;  // any hit will do
  bool is_cutout;  // against the cut-out triangles, else the opaque ones
};

/// What one call did, for reports.
struct RenderStatistics {
  uint64_t paths = 0;             // of pixels that may see something
  uint64_t closest_hit_rays = 0;  // camera and indirect rays, cut-outs passed included
  uint64_t shadow_rays = 0;
  uint64_t walks = 0;          // under the surface
  uint64_t walk_segments = 0;  // their rays
  uint64_t walk_leaks =
      0;  // that ended outside the model's bounding box: it is open, or a ray slipped through
  uint64_t nonfinite = 0;  // contributions that were NaN or infinite and left out
  double seconds = 0;
  std::vector<RecordedRay>* record = nullptr;  // if set, receives every query, tile by tile
};

/// Geometry, texels and bounding volume hierarchies of a model, built once for all views.
class Scene;
std::shared_ptr<const Scene> build_scene(const Model& model);

/// Environments and point lights with their sampling tables.
class LightSet;
std::shared_ptr<const LightSet> prepare_lights(const std::vector<Environment>& environments,
                                               const std::vector<PointLight>& points);

/// Called from any thread with the number of finished pixels of the last tile.
using PixelsDone = std::function<void(size_t)>;

/// The material maps of a view: Sample without lights. `turn_rad` turns the subject about +Y.
/// A regular grid of points a pixel; where cut-outs overlap, each layer counts by what it covers.
Sample render_maps(const Scene& scene, const Camera& camera, double turn_rad, const RenderSettings& settings,
                   const PixelsDone& done = nullptr);

/// What a camera sees of a scene in some lights; `turn_rad` turns the subject about +Y. Borrows all of it.
struct LitView {
  const Scene& scene;
  const LightSet& lights;
  const Camera& camera;
  double turn_rad;
};

/// One radiance image a light (linear Rec. 709, premultiplied by coverage, background black), environments
/// first. One path traversal serves all lights; each image is unbiased by itself. Bit-identical for any
/// thread count.
std::vector<SampleLight> render_lights(const LitView& view, const RenderSettings& settings,
                                       RenderStatistics* statistics = nullptr,
                                       const PixelsDone& done = nullptr);

std::string ray_library_version();

}  // namespace ohb::renderer
