#include "dataset/commands/render_samples.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <set>

#include "dataset/commands/sample_output.h"
#include "dataset/commands/sample_previews.h"
#include "dataset/model/error.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/model_identity.h"
#include "dataset/model/progress.h"

namespace ohb::commands {
namespace fs = std::filesystem;
namespace {

/// To two digits: what is above 1 never reads 1.00.
double rounded_up(double ratio) {
  return std::ceil(100 * ratio) / 100;
}

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

template <typename T>
bool parse_number(std::string_view text, T& value) {
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  return result.ec == std::errc() && result.ptr == text.data() + text.size();
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (size_t begin = 0;;) {
    const size_t end = text.find(separator, begin);
    parts.push_back(text.substr(begin, end - begin));
    if (end == std::string_view::npos) return parts;
    begin = end + 1;
  }
}

void check_lights(const RenderJob& job, const std::vector<Environment>& environments) {
  if (environments.empty() && job.points.empty())
    throw InputError("", "render", "there is no light", "give --environment E.exr or --point x,y,z,I");
  std::set<std::string> names;
  for (const Environment& environment : environments)
    if (!names.insert(environment.name).second)
      throw InputError(environment.file.string(), "",
                       "another environment is named '" + environment.name + "' too",
                       "rename one of the files: parts of a sample are named by them");
}

bool has_subsurface(const Model& model) {
  for (const TextureSet& set : model.sets)
    for (const float value : set.sss.values)
      if (value > 0) return true;
  return false;
}

/// Builds what the quality asks for and says what it leaves out. Pilots look at three of the job's views.
renderer::PreparedScene prepare(const RenderJob& job, const Model& model,
                                const std::vector<Environment>& environments, const Camera& camera,
                                RenderReport& report) {
  const auto start = Clock::now();
  const std::vector<int>& views = job.views.indices;
  std::vector<renderer::QualityView> looked_at;
  for (size_t k = 0; k < std::min<size_t>(3, views.size()); ++k)
    looked_at.push_back(
        {camera, turn_of_view(views[k * views.size() / std::min<size_t>(3, views.size())], job.views.count)});
  renderer::PreparedScene prepared =
      renderer::prepare_scene(model, environments, job.points, looked_at, job.settings,
                              {job.quality, job.tolerance, static_cast<int>(views.size())});
  for (const renderer::Omission& o : prepared.tried)
    spdlog::info("{} {}: changes the image by {:.2g} (98 % sure: {:.2g} to {:.2g})",
                 o.is_left_out ? "left out:" : "kept: without", o.what, o.error, o.low, o.high);
  if (job.quality == renderer::Quality::kAuto)
    spdlog::info("all together change it by {:.2g} at most; tolerance {:.2g}", prepared.error_high,
                 job.tolerance);
  report.load_seconds += seconds_since(start);
  return prepared;
}

/// To the goal, with a warning if it is not reached. Progress counts pixels: as many are done as the share of
/// the goal's paths that the error says.
std::vector<SampleLight> render_goal(const renderer::LitView& view, const renderer::RenderSettings& settings,
                                     const renderer::ErrorGoal& goal, RenderedView& rendered,
                                     Progress& progress) {
  const size_t pixels = static_cast<size_t>(settings.size_px) * settings.size_px;
  size_t shown = 0;
  const auto show = [&](double share) {
    const size_t done = std::max(shown, static_cast<size_t>(share * static_cast<double>(pixels)));
    progress.add(done - shown);
    shown = done;
  };
  std::vector<SampleLight> images = renderer::render_to_error(
      view, settings, goal, rendered.error,
      {&rendered.statistics, [](size_t) { throw_if_interrupted(); },
       [&](double error) {
         progress.note(fmt::format("error {:.3g} of {:.3g}", error, goal.relative_error));
         show(std::isfinite(error) ? std::min(1.0, std::pow(goal.relative_error / error, 2)) : 0);
       }});
  show(1);
  const renderer::RegionError* worst = rendered.error.worst();
  if (!rendered.error.met && worst)
    spdlog::warn(
        "view {}: the error is {:.2f} times the goal of {:.3g} ({} under {}) after {:.0f} paths a pixel; for "
        "less, raise --max-spp",
        rendered.view, rounded_up(worst->relative_error / goal.relative_error), goal.relative_error,
        worst->region, worst->light, rendered.error.spp);
  return images;
}

/// One view of what a job prepared, rendered and written.
class ViewRender {
 public:
  ViewRender(const RenderJob& job, const Model& model, const Camera& camera,
             const renderer::PreparedScene& prepared, SampleOutput& output, Progress& progress)
      : job_(job),
        model_(model),
        camera_(camera),
        prepared_(prepared),
        output_(output),
        progress_(progress) {}

  void operator()(int view, RenderedView& rendered) const {
    renderer::RenderSettings settings = prepared_.settings_for(job_.settings);
    settings.seed = seed_of_view(job_.settings.seed, model_.name, view, job_.views.count);
    const double turn_rad = turn_of_view(view, job_.views.count);
    const auto map_start = Clock::now();
    Sample sample = renderer::render_maps(*prepared_.scene, camera_, turn_rad, settings,
                                          [](size_t) { throw_if_interrupted(); });
    rendered.map_seconds = seconds_since(map_start);
    sample.lights = lights({*prepared_.lit, *prepared_.lights, camera_, turn_rad}, settings, rendered);
    if (rendered.statistics.nonfinite > 0)
      spdlog::warn("view {}: {} contributions were NaN or infinite and left out", view,
                   rendered.statistics.nonfinite);
    sample.attributes = output_.attributes_of(view);
    add_needs(job_, prepared_, sample.attributes);
    if (job_.goal) add_reached(rendered.error, sample.attributes);
    write_previews(job_.output / "previews", view_name(view), sample);
    write_sample(rendered.file, sample);
  }

 private:
  std::vector<SampleLight> lights(const renderer::LitView& lit, const renderer::RenderSettings& settings,
                                  RenderedView& rendered) const {
    if (job_.goal) return render_goal(lit, settings, *job_.goal, rendered, progress_);
    return renderer::render_lights(lit, settings, &rendered.statistics, [&](size_t n) {
      throw_if_interrupted();
      progress_.add(n);
    });
  }

  const RenderJob& job_;
  const Model& model_;
  const Camera& camera_;
  const renderer::PreparedScene& prepared_;
  SampleOutput& output_;
  Progress& progress_;
};

}  // namespace

ViewList parse_views(const std::string& text) {
  const auto fail = [&]() {
    throw InputError("", "--views " + text, "is not a list of views",
                     "write N (all of N) or N:i,j,... with 0 <= i < N");
  };
  ViewList views;
  const size_t colon = text.find(':');
  if (!parse_number(std::string_view(text).substr(0, colon), views.count) || views.count < 1 ||
      views.count > 100000)
    fail();
  views.indices.clear();
  if (colon == std::string::npos)
    for (int i = 0; i < views.count; ++i) views.indices.push_back(i);
  else
    for (const std::string_view part : split(std::string_view(text).substr(colon + 1), ',')) {
      int index = -1;
      if (!parse_number(part, index) || index < 0 || index >= views.count) fail();
      if (std::find(views.indices.begin(), views.indices.end(), index) != views.indices.end())
        throw InputError("", "--views " + text, "names view " + std::to_string(index) + " twice",
                         "name it once");
      views.indices.push_back(index);
    }
  return views;
}

renderer::PointLight parse_point_light(const std::string& text, size_t index) {
  const std::vector<std::string_view> parts = split(text, ',');
  float v[4] = {};
  bool good = parts.size() == 4;
  for (size_t i = 0; good && i < 4; ++i) good = parse_number(parts[i], v[i]) && std::isfinite(v[i]);
  if (!good || v[3] < 0)
    throw InputError("", "--point " + text, "is not a point light",
                     "write x,y,z,I: the position in cm and the intensity (irradiance at 1 m), I >= 0");
  return {"point" + std::to_string(index), {v[0], v[1], v[2]}, v[3]};
}

uint64_t seed_of_view(uint64_t job_seed, const std::string& model_name, int view, int view_count) {
  // FNV-1a: a fixed hash, since std::hash may differ between libraries.
  uint64_t hash = 0xcbf29ce484222325ull;
  for (const char c : model_name + "/" + std::to_string(view) + "/" + std::to_string(view_count) + "/" +
                          std::to_string(job_seed))
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ull;
  return hash;
}

RenderReport render_samples(const RenderJob& job) {
  const auto start = Clock::now();
  std::vector<Environment> environments;
  for (const fs::path& file : job.environments) environments.push_back(read_environment(file));
  check_lights(job, environments);
  const Model model = read_model(job.model_folder, ModelParts::kForRendering);
  RenderReport report;
  report.subsurface_replaced = !job.settings.subsurface && has_subsurface(model);
  const Camera camera = fit_camera(model.positions_cm);
  SampleOutput output(job.output,
                      settings_of(job, model.name, model_identity(job.model_folder), environments, camera),
                      job.overwrites);
  report.load_seconds = seconds_since(start);

  const size_t pixels = static_cast<size_t>(job.settings.size_px) * job.settings.size_px;
  Progress progress("rendering", job.views.indices.size() * pixels, job.quiet);
  for (const int view : job.views.indices) {
    RenderedView rendered;
    rendered.view = view;
    rendered.file = output.file_of(view);
    if (output.is_done(view)) {
      rendered.was_there = true;
      progress.add(pixels);
    } else {
      if (!report.prepared.scene) report.prepared = prepare(job, model, environments, camera, report);
      ViewRender(job, model, camera, report.prepared, output, progress)(view, rendered);
    }
    report.views.push_back(rendered);
    output.add(rendered, job, report);
  }
  return report;
}

}  // namespace ohb::commands
