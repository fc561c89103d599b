#include "renderer/quality.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "dataset/model/stopwatch.h"
#include "renderer/coarser.h"
#include "renderer/paired_pilots.h"

namespace ohb::renderer {
namespace {

constexpr int kImages = 16, kFirstSpp = 1, kMostSpp = 16;
constexpr size_t kPilotPixels = 1024;
constexpr double kAttemptShare = 1.0 / 64;  // of the job's paths
constexpr int kLeastWidth_px = 64;
constexpr double kAlpha = 0.02;  // two-sided: the upper end is a bound of 99 %
// What earlier kinds may use up of the tolerance, so that later ones have a chance.
constexpr double kEnvironmentPart = 0.6, kSubsurfacePart = 0.8, kBouncesPart = 0.95, kMapsPart = 1;

std::vector<Environment> limited(const std::vector<Environment>& environments, int width_px) {
  std::vector<Environment> result;
  for (const Environment& environment : environments) {
    int halvings = 0;
    while (environment.radiance.width_px >> halvings > width_px) ++halvings;
    result.push_back(coarser_environment(environment, halvings));
  }
  return result;
}

/// Builds scenes and lights of given needs, one variant of each at a time beside the full ones.
class Variants {
 public:
  Variants(const Model& model, const std::vector<Environment>& environments,
           const std::vector<PointLight>& points)
      : model_(model),
        environments_(environments),
        points_(points),
        full_scene_(build_scene(model)),
        full_lights_(prepare_lights(environments, points)),
        largest_map_px_(largest_map_px(model)) {
    for (const Environment& e : environments)
      largest_environment_px_ = std::max(largest_environment_px_, e.radiance.width_px);
  }
  PreparedScene prepare(const Needs& needs) {
    PreparedScene prepared{needs, full_scene_, full_scene_, full_lights_, {}, 0, 1};
    if (needs.map_px < largest_map_px_) {
      if (map_px_ != needs.map_px) small_scene_ = build_scene(with_coarser_maps(model_, needs.map_px));
      map_px_ = needs.map_px;
      prepared.lit = small_scene_;
    }
    if (needs.environment_px < largest_environment_px_) {
      if (environment_px_ != needs.environment_px)
        small_lights_ = prepare_lights(limited(environments_, needs.environment_px), points_);
      environment_px_ = needs.environment_px;
      prepared.lights = small_lights_;
    }
    return prepared;
  }
  int largest_map() const { return largest_map_px_; }
  size_t environment_count() const { return environments_.size(); }
  /// The full width, and half of it, a quarter ...
  std::vector<int> environment_widths() const {
    std::vector<int> widths;
    for (int px = largest_environment_px_; px >= kLeastWidth_px; px /= 2) widths.push_back(px);
    return widths;
  }
  /// The environments at each of these widths, one set after the other.
  std::shared_ptr<const LightSet> all_environments() {
    if (all_environments_) return all_environments_;
    std::vector<Environment> all;
    for (const int px : environment_widths())
      for (Environment& environment : limited(environments_, px)) all.push_back(std::move(environment));
    return all_environments_ = prepare_lights(all, {});
  }

 private:
  const Model& model_;
  const std::vector<Environment>& environments_;
  const std::vector<PointLight>& points_;
  std::shared_ptr<const Scene> full_scene_, small_scene_;
  std::shared_ptr<const LightSet> full_lights_, small_lights_, all_environments_;
  int largest_map_px_, largest_environment_px_ = 0;
  int map_px_ = 0, environment_px_ = 0;
};

bool has_subsurface(const Model& model) {
  for (const TextureSet& set : model.sets)
    for (const float value : set.sss.values)
      if (value > 0) return true;
  return false;
}

/// Pilots of every view with one number of paths.
struct ViewPilots {
  std::vector<PilotStack> stacks;
  double cpu_s = 0;
};

class Choice {
 public:
  Choice(const Model& model, Variants& variants, const std::vector<QualityView>& views,
         const RenderSettings& settings, const QualityGoal& goal)
      : model_(model),
        variants_(variants),
        views_(views),
        job_views_(goal.job_views),
        settings_(settings),
        tolerance_(goal.tolerance) {
    const PreparedScene all = variants_.prepare(Needs());
    double attempt = 0;  // paths of one, at 1 a pixel
    for (const QualityView& view : views_) {
      const Picture picture({*all.scene, *all.lights, view.camera, view.turn_rad}, settings_);
      attempt += kImages * static_cast<double>(pilot_pixels(picture, kPilotPixels).size());
      job_paths_ += settings_.spp * static_cast<double>(job_views_) / static_cast<double>(views_.size()) *
                    static_cast<double>(std::count(picture.seen.begin(), picture.seen.end(), 1));
    }
    for (int spp = kFirstSpp; spp <= kMostSpp; spp *= 4)
      if (spp * attempt <= kAttemptShare * job_paths_) most_spp_ = spp;
  }

  PreparedScene run() {
    limit_environments();
    if (settings_.subsurface && has_subsurface(model_))
      keeps("subsurface", kSubsurfacePart, [](Needs& needs) { needs.subsurface = false; });
    for (const int bounces : {0, 1, 2})
      if (bounces < settings_.max_bounces && keeps(fmt::format("bounces beyond {}", bounces), kBouncesPart,
                                                   [&](Needs& needs) { needs.max_bounces = bounces; }))
        break;
    for (int px = variants_.largest_map() / 2; px >= kLeastWidth_px; px /= 2)
      if (!keeps(fmt::format("maps at {} px", px), kMapsPart, [&](Needs& needs) { needs.map_px = px; }))
        break;
    PreparedScene prepared = variants_.prepare(needs_);
    prepared.tried = tried_;
    prepared.error_high = error_high_;
    prepared.cpu_share = cpu_share_;
    return prepared;
  }

 private:
  ViewPilots pilots(const Scene& scene, const LightSet& lights, RenderSettings settings, int spp) const {
    const Stopwatch watch;
    settings.guess_shadows = false;  // or each light, and each variant, would send other rays
    ViewPilots result;
    RenderStatistics statistics;
    for (const QualityView& view : views_) {
      const Picture picture({scene, lights, view.camera, view.turn_rad}, settings);
      result.stacks.push_back(render_pilot_stack(picture, pilot_pixels(picture, kPilotPixels), kImages, spp,
                                                 statistics, nullptr));
    }
    result.cpu_s = watch.cpu_s();
    return result;
  }
  ViewPilots pilots(const Needs& needs, int spp) const {
    const PreparedScene prepared = variants_.prepare(needs);
    RenderSettings settings = prepared.settings_for(settings_);
    // The same rays where nothing is left out: pairs differ by that alone, not by their noise.
    settings.ends_at_rough_surfaces = false;
    return pilots(*prepared.lit, *prepared.lights, settings, spp);
  }

  const ViewPilots& reference(int spp) {
    auto known = references_.find(spp);
    if (known == references_.end()) known = references_.emplace(spp, pilots(Needs(), spp)).first;
    return known->second;
  }

  /// Every light of b, from the `skip`-th on, against a's: the largest of lights and views.
  static void measure(const ViewPilots& a, const ViewPilots& b, size_t skip, size_t lights,
                      Omission& omission) {
    const auto root = [](double x) { return std::sqrt(std::max(0.0, x)); };
    omission.error = omission.low = omission.high = 0;
    for (size_t v = 0; v < a.stacks.size(); ++v)
      for (size_t l = 0; l < lights; ++l) {
        const SquaredDifference d = squared_difference(a.stacks[v], l, b.stacks[v], skip + l, kAlpha);
        omission.low = std::max(omission.low, root(d.low));
        if (root(d.high) < omission.high) continue;
        omission.error = root(d.value), omission.high = root(d.high);
      }
  }

  /// True if the interval says yes or no.
  bool is_clear(Omission& omission, double part) const {
    omission.is_left_out = omission.high <= part * tolerance_;
    return omission.is_left_out || omission.low > part * tolerance_;
  }

  /// All widths as lights of one pass: they differ by the lookups alone.
  void limit_environments() {
    const std::vector<int> widths = variants_.environment_widths();
    std::vector<Omission> found;
    const auto finest_doubt = [&] {
      for (Omission& omission : found)
        if (!is_clear(omission, kEnvironmentPart))
          return true;
        else if (!omission.is_left_out)
          return false;
      return false;
    };
    for (int spp = kFirstSpp; spp <= most_spp_ && widths.size() > 1; spp *= 4) {
      const size_t lights = variants_.environment_count();
      const ViewPilots all =
          pilots(*variants_.prepare(Needs()).scene, *variants_.all_environments(), settings_, spp);
      found.assign(widths.size() - 1, Omission());
      for (size_t w = 1; w < widths.size(); ++w) {
        found[w - 1].what = fmt::format("environments at {} px", widths[w]);
        measure(all, all, w * lights, lights, found[w - 1]);
      }
      if (!finest_doubt()) break;
    }
    for (size_t w = 0; w < found.size(); ++w) {
      is_clear(found[w], kEnvironmentPart);
      tried_.push_back(found[w]);
      if (!found[w].is_left_out) break;
      needs_.environment_px = widths[w + 1];
      error_high_ = found[w].high;
    }
  }

  template <typename Change>
  bool keeps(const std::string& what, double part, const Change& change) {
    if (most_spp_ == 0) return false;
    Needs needs = needs_;
    change(needs);
    Omission omission{what};
    double cpu_share = 1;
    for (int spp = kFirstSpp; spp <= most_spp_; spp *= 4) {
      const ViewPilots& all = reference(spp);
      const ViewPilots without = pilots(needs, spp);
      cpu_share = all.cpu_s > 0 ? without.cpu_s / all.cpu_s : 1;
      measure(all, without, 0, all.stacks[0][0].size(), omission);
      if (is_clear(omission, part)) break;
    }
    tried_.push_back(omission);
    if (omission.is_left_out) {
      needs_ = needs;
      error_high_ = omission.high;
      cpu_share_ = cpu_share;
    }
    return omission.is_left_out;
  }

  const Model& model_;
  Variants& variants_;
  const std::vector<QualityView>& views_;
  const int job_views_;
  const RenderSettings settings_;
  const double tolerance_;
  double job_paths_ = 0;
  int most_spp_ = 0;  // of an attempt; 0: none may be made
  Needs needs_;
  std::map<int, ViewPilots> references_;
  std::vector<Omission> tried_;
  double error_high_ = 0, cpu_share_ = 1;
};

}  // namespace

RenderSettings PreparedScene::settings_for(RenderSettings settings) const {
  settings.subsurface = settings.subsurface && needs.subsurface;
  if (needs.max_bounces < settings.max_bounces) {
    settings.max_bounces = needs.max_bounces;
    settings.ends_at_rough_surfaces = true;
  }
  return settings;
}

PreparedScene prepare_scene(const Model& model, const std::vector<Environment>& environments,
                            const std::vector<PointLight>& points, const std::vector<QualityView>& views,
                            const RenderSettings& settings, const QualityGoal& goal) {
  Variants variants(model, environments, points);
  if (goal.quality == Quality::kReference) return variants.prepare(Needs());
  if (goal.quality == Quality::kFast) return variants.prepare(kFastNeeds);
  return Choice(model, variants, views, settings, goal).run();
}

}  // namespace ohb::renderer
