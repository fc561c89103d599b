#include "dataset/production/person_renderer.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "dataset/commands/sample_output.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/sample_listing.h"
#include "dataset/model/stopwatch.h"
#include "dataset/model/xml_document.h"
#include "dataset/production/units.h"

namespace ohb::production {
namespace fs = std::filesystem;
namespace {

/// The views as a job of `render`, for what its samples say of themselves.
commands::RenderJob render_job(const Plan& plan, const ViewSet& views, const fs::path& model) {
  commands::RenderJob job;
  job.model_folder = model;
  job.points = views.points;
  job.views.count = views.view_count;
  job.settings.size_px = views.size_px;
  job.settings.spp = views.spp;
  job.settings.seed = plan.seed;
  job.settings.max_bounces = views.max_bounces;
  job.settings.subsurface = views.subsurface;
  job.settings.shading = views.shading;
  job.settings.adaptive = true;
  job.goal = views.goal;
  return job;
}

}  // namespace

PersonRenderer::PersonRenderer(const Plan& plan, const PlanPerson& person, BakedPerson baked)
    : plan_(plan), person_(person), views_(plan.views_of(person)), baked_(std::move(baked)) {}

std::string PersonRenderer::unit_hash(const PlannedSet& set, FileHashes& hashes) const {
  // The camera is a function of the model: an unfitted one stands for it here.
  const commands::RenderJob job = render_job(plan_, views_, baked_.model);
  std::vector<std::pair<std::string, std::string>> parts = {
      {"set", OHB_VERSION},
      {"settings", identity_of(commands::settings_of(job, person_.id, baked_.identity, {}, Camera()))},
      {"view", std::to_string(set.view)},
      {"number", std::to_string(set.number)},
      {"seed", std::to_string(set.seed)}};
  for (const PlanEnvironment* environment : set.environments)
    parts.emplace_back("environment " + environment->name, hashes.of(environment->file));
  return hash_of_parts(parts);
}

void PersonRenderer::load() {
  if (scene_) return;
  const Stopwatch watch;
  const Model model = read_model(baked_.model, ModelParts::kForRendering);
  scene_ = renderer::build_scene(model);
  camera_ = fit_camera(model.positions_cm);
  shared_ = commands::settings_of(render_job(plan_, views_, baked_.model), person_.id, baked_.identity, {},
                                  camera_);
  times_.loading_s = watch.wall_s();
}

const ExrAttributes& PersonRenderer::settings() {
  load();
  return shared_;
}

renderer::RenderSettings PersonRenderer::settings_of(const PlannedSet& set) const {
  renderer::RenderSettings settings = render_job(plan_, views_, baked_.model).settings;
  settings.seed = set.seed;
  return settings;
}

ExrAttributes PersonRenderer::attributes_of(const PlannedSet& set, FileHashes& hashes) {
  ExrAttributes attributes = shared_;
  attributes.emplace_back("ohb:view", std::to_string(set.view));
  attributes.emplace_back("ohb:turn_deg", shortest(360.0 * set.view / views_.view_count));
  attributes.emplace_back("ohb:identity", identity_of(shared_));
  attributes.emplace_back("ohb:set.number", std::to_string(set.number));
  attributes.emplace_back("ohb:set.seed", std::to_string(set.seed));
  for (const PlanEnvironment* environment : set.environments)
    attributes.emplace_back("ohb:set.environment." + environment->name, hashes.of(environment->file));
  return attributes;
}

Sample PersonRenderer::render(const PlannedSet& set, FileHashes& hashes, const std::function<void()>& alive) {
  return render(set, hashes, views_.goal ? 0 : views_.spp, alive);
}

Sample PersonRenderer::render(const PlannedSet& set, FileHashes& hashes, int spp,
                              const std::function<void()>& alive) {
  load();
  std::vector<fs::path> files;
  std::vector<std::string> contents;
  for (const PlanEnvironment* environment : set.environments) {
    files.push_back(environment->file);
    contents.push_back(hashes.of(environment->file));
  }
  Stopwatch watch;
  const auto lap = [&watch](double& seconds) {
    seconds += watch.wall_s();
    watch = Stopwatch();
  };
  const auto lights = environments_.take(files, contents, views_.points);
  lap(times_.environments_s);
  renderer::RenderSettings settings = settings_of(set);
  settings.spp = std::max(spp, 1);
  const double turn_rad = turn_of_view(set.view, views_.view_count);
  const auto done = [&](size_t) { alive(); };
  Sample sample = renderer::render_maps(*scene_, camera_, turn_rad, settings, done);
  lap(times_.maps_s);
  renderer::RenderStatistics statistics;
  renderer::ErrorReport reached;
  const renderer::LitView lit{*scene_, *lights, camera_, turn_rad};
  sample.lights = spp == 0
                      ? renderer::render_to_error(lit, settings, *views_.goal, reached, {&statistics, done})
                      : renderer::render_lights(lit, settings, &statistics, done);
  lap(times_.lights_s);
  environments_.give_back();
  if (statistics.nonfinite > 0)
    spdlog::warn("set {}: {} contributions were NaN or infinite and left out", set.number,
                 statistics.nonfinite);
  sample.attributes = attributes_of(set, hashes);
  if (spp == 0) commands::add_reached(reached, sample.attributes);
  return sample;
}

}  // namespace ohb::production
