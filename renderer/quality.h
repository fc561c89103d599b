// What a scene needs: features whose absence a picture would not show are left out.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "renderer/render.h"

namespace ohb::renderer {

enum class Quality {
  kReference,  // everything that the settings allow
  kFast,       // kFastNeeds, whatever that changes
  kAuto        // what pilots show to change no light's image by more than a tolerance
};

/// What is rendered with. A limit that is above what the model or the settings have changes nothing.
struct Needs {
  bool subsurface = true;  // false: skin reflects diffusely
  int max_bounces = 1 << 20;
  int environment_px = 1 << 20;  // largest width, by halving
  int map_px = 1 << 20;          // largest width of the model's maps, by halving
};
constexpr Needs kFastNeeds{false, 1, 256, 1024};

/// One thing that was tried to be left out, together with all that was left out before it.
struct Omission {
  std::string what;  // "environments at 256 px", "subsurface", "bounces beyond 1", "maps at 512 px" ...
  /// Relative change of the light's image that changes most: the root of sum of (expected difference)^2 / sum
  /// of (expected value)^2 over the subject, and the ends of its 98 % confidence interval.
  double error = 0, low = 0, high = 0;
  bool is_left_out = false;
};

/// A scene made ready for render_lights, and why it is as it is.
struct PreparedScene {
  Needs needs;
  std::shared_ptr<const Scene> scene;  // with full maps, for render_maps
  std::shared_ptr<const Scene> lit;    // for render_lights; may be the same
  std::shared_ptr<const LightSet> lights;
  std::vector<Omission> tried;  // kAuto
  double error_high = 0;        // of all that is left out together
  double cpu_share = 1;         // processor time of its pilots over the reference's; not deterministic

  /// The settings with what is not needed turned off.
  RenderSettings settings_for(RenderSettings settings) const;
};

/// The views that the pilots of kAuto look at.
struct QualityView {
  Camera camera;
  double turn_rad = 0;
};

/// What a job may leave out: `job_views` images are to be made; `tolerance` is that of kAuto.
struct QualityGoal {
  Quality quality = Quality::kReference;
  double tolerance = 0;
  int job_views = 1;
};

/// For kAuto, tries in a fixed order: environments of half, a quarter ... of their width (all in one pass),
/// no subsurface, fewer bounces; smaller maps. Each is rendered beside the reference with the same random
/// numbers, 16 independent pairs over some 1000 pixels of each view, and told from noise as paired_pilots.h
/// says. Something is left out only if the interval's upper end is within the tolerance, for all that is left
/// out together, in every light and view. In doubt the pilots get up to 16 times the paths, as long as one
/// attempt takes no more than 1/64 of the job (`job_views` images of settings.spp paths); then it stays.
/// Never uses a clock: the same job makes the same choice.
PreparedScene prepare_scene(const Model& model, const std::vector<Environment>& environments,
                            const std::vector<PointLight>& points, const std::vector<QualityView>& views,
                            const RenderSettings& settings, const QualityGoal& goal);

}  // namespace ohb::renderer
