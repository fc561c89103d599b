// Samples of a model: one multi-part EXR a view, PNG previews beside them, resumable view by view.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "renderer/quality.h"
#include "renderer/render_to_error.h"

namespace ohb::commands {

/// Which views of how many around one full turn; view 0 is frontal.
struct ViewList {
  int count = 1;
  std::vector<int> indices{0};
};

/// "8" is all of 8 views; "100:0,25" is views 0 and 25 of 100. Throws InputError for anything else.
ViewList parse_views(const std::string& text);

/// "x,y,z,I": position in cm and radiant intensity (PointLight in renderer/render.h). Throws InputError.
renderer::PointLight parse_point_light(const std::string& text, size_t index);

struct RenderJob {
  std::filesystem::path model_folder;
  std::vector<std::filesystem::path> environments;
  std::vector<renderer::PointLight> points;
  ViewList views;
  renderer::RenderSettings settings;        // seed is the job's; each view derives its own
  std::optional<renderer::ErrorGoal> goal;  // instead of settings.spp
  renderer::Quality quality = renderer::Quality::kReference;
  double tolerance = 0.02;  // of Quality::kAuto
  std::filesystem::path output;
  bool overwrites = false;  // views of other settings are replaced
  bool quiet = false;       // no progress bar
};

struct RenderedView {
  int view = 0;
  std::filesystem::path file;
  bool was_there = false;  // an earlier run had written it with the same parameters
  double map_seconds = 0;
  renderer::RenderStatistics statistics;
  renderer::ErrorReport error;  // of a goal; empty if the view was there
};

struct RenderReport {
  std::vector<RenderedView> views;
  double load_seconds = 0;
  renderer::PreparedScene prepared;  // what was rendered with; empty if all views were there
  bool subsurface_replaced = false;  // the model has subsurface, which is rendered as diffuse reflection
};

/// Writes view_<kkk>.exr and previews/ into job.output, and render.json with the settings that they share and
/// a line for each. A view whose file is there with the same settings is not rendered again; views of other
/// settings are refused, or removed with job.overwrites (SampleOutput). Throws InputError (model,
/// environments, no light at all, two lights of one name, an output of other settings or of another kind),
/// TryAgainError (disk full; SIGINT or SIGTERM, finished views are kept).
RenderReport render_samples(const RenderJob& job);

/// Seed of one view's image: a function of the job's seed, the model's name and the view.
uint64_t seed_of_view(uint64_t job_seed, const std::string& model_name, int view, int view_count);

}  // namespace ohb::commands
