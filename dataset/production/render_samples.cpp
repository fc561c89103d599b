#include "dataset/production/render_samples.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/progress.h"
#include "dataset/production/sample_previews.h"

namespace ohb {
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

std::string shortest(double value) {
  char buffer[64];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

const char* quality_name(Quality quality) {
  return quality == Quality::kAuto ? "auto" : quality == Quality::kFast ? "fast" : "reference";
}

ExrAttributes attributes_of(const RenderJob& job, const Model& model, const std::string& model_sha256,
                            const std::vector<Environment>& environments, const Camera& camera, int view) {
  const RenderSettings& s = job.settings;
  ExrAttributes a = {
      {"ohb:human", model.name},
      {"ohb:modelHash", model_sha256},
      {"ohb:view", std::to_string(view)},
      {"ohb:viewCount", std::to_string(job.views.count)},
      {"ohb:turn_deg", shortest(360.0 * view / job.views.count)},
      {"ohb:seed", std::to_string(s.seed)},
      {job.goal ? "ohb:maxSpp" : "ohb:spp", std::to_string(job.goal ? job.goal->max_spp : s.spp)},
      {"ohb:sampling", s.adaptive ? "adaptive" : "even"},
      {"ohb:maxBounces", std::to_string(s.max_bounces)},
      {"ohb:mapGrid", std::to_string(s.map_grid)},
      {"ohb:subsurface", s.subsurface ? "random walk" : "replaced by diffuse"},
      {"ohb:unit", "cm"},
      {"ohb:cameraCenterY_cm", shortest(camera.center_y_cm)},
      {"ohb:cameraDistance_cm", shortest(camera.distance_cm)},
      {"ohb:cameraHalfWidth", shortest(camera.half_width)},
      {"ohb:displacementRange_cm", shortest(camera.half_frame_cm())},
      {"ohb:conventions",
       "normal: camera space, +X right, +Y up, +Z to the viewer; specular: S, F0 = sRGB_to_linear(S); "
       "roughness: alpha = roughness^2; displacement: cm from the plane z = 0 towards the camera; "
       "relit: linear Rec. 709, premultiplied by mask"},
      {"ohb:toolVersion", OHB_VERSION},
  };
  a.emplace_back("ohb:quality", quality_name(job.quality));
  if (job.quality == Quality::kAuto) a.emplace_back("ohb:tolerance", shortest(job.tolerance));
  if (job.goal) a.emplace_back("ohb:error", shortest(job.goal->relative_error));
  // Samples of v1 keep the attributes that they had before there was another.
  if (s.shading == ShadingModel::kV2) a.emplace_back("ohb:shadingModel", "Principled v2, Blender 4.5");
  for (const Environment& environment : environments)
    a.emplace_back("ohb:environment." + environment.name, environment.sha256);
  for (const PointLight& light : job.points)
    a.emplace_back("ohb:point." + light.name,
                   shortest(light.position_cm.x) + "," + shortest(light.position_cm.y) + "," +
                       shortest(light.position_cm.z) + "," + shortest(light.intensity));
  return a;
}

// What rendering found out, which no parameter says beforehand.
constexpr const char* kReached = "ohb:reached.";

constexpr const char* kNeeds = "ohb:needs.";

/// What was rendered with, where it is less than everything.
void add_needs(const RenderJob& job, const PreparedScene& prepared, ExrAttributes& attributes) {
  if (job.quality == Quality::kReference) return;
  const auto add = [&](const std::string& name, const std::string& value) {
    attributes.emplace_back(kNeeds + name, value);
  };
  const Needs& needs = prepared.needs;
  const auto limit = [](int value) { return value == Needs().map_px ? "all" : std::to_string(value); };
  add("subsurface", needs.subsurface ? "all" : "none");
  add("shadows", needs.shadow_rays ? "rays" : "cache");
  add("maxBounces", limit(needs.max_bounces));
  add("environment_px", limit(needs.environment_px));
  add("map_px", limit(needs.map_px));
  if (job.quality == Quality::kAuto) add("errorAtMost", fmt::format("{:.4g}", prepared.error_high));
}

void add_reached(const ErrorReport& error, ExrAttributes& attributes) {
  attributes.emplace_back(std::string(kReached) + "spp", fmt::format("{:.1f}", error.spp));
  for (const RegionError& e : error.errors)
    attributes.emplace_back(kReached + ("error." + e.light) + "." + e.region,
                            fmt::format("{:.4g}", e.relative_error));
}

// Written by this version with these parameters? Anything else (another file, a broken one) is rendered anew.
bool is_done(const fs::path& file, ExrAttributes wanted) {
  if (!fs::exists(file)) return false;
  try {
    ExrAttributes found;
    for (auto& attribute : read_sample(file).attributes)
      if (attribute.first.rfind(kReached, 0) != 0 && attribute.first.rfind(kNeeds, 0) != 0)
        found.push_back(attribute);
    std::sort(found.begin(), found.end());
    std::sort(wanted.begin(), wanted.end());
    return found == wanted;
  } catch (const InputError&) {
    return false;
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

nlohmann::json quality_json(const RenderJob& job, const PreparedScene& prepared) {
  const Needs& needs = prepared.needs;
  const auto limit = [](int value) {
    return value == Needs().map_px ? nlohmann::json() : nlohmann::json(value);
  };
  nlohmann::json json = {{"quality", quality_name(job.quality)},
                         {"subsurface", needs.subsurface},
                         {"shadow_rays", needs.shadow_rays},
                         {"max_bounces", limit(needs.max_bounces)},
                         {"environment_px", limit(needs.environment_px)},
                         {"map_px", limit(needs.map_px)}};
  if (job.quality != Quality::kAuto) return json;
  json["tolerance"] = job.tolerance;
  json["error_at_most"] = prepared.error_high;
  json["processor_time_of_pilots_to_reference"] = prepared.cpu_share;
  for (const Omission& o : prepared.tried)
    json["tried"].push_back({{"what", o.what},
                             {"left_out", o.is_left_out},
                             {"error", o.error},
                             {"low", o.low},
                             {"high", o.high}});
  return json;
}

nlohmann::json error_json(const ErrorGoal& goal, const ErrorReport& error) {
  nlohmann::json json = {{"goal", goal.relative_error}, {"met", error.met}, {"spp", error.spp}};
  for (const RegionError& e : error.errors)
    json["reached"].push_back({{"light", e.light},
                               {"region", e.region},
                               {"pixels", e.pixels},
                               {"relative_error", e.relative_error}});
  return json;
}

void write_render_json(const RenderJob& job, const RenderReport& report) {
  nlohmann::json json;
  json["load_s"] = report.load_seconds;
  json["subsurface_replaced_by_diffuse"] = report.subsurface_replaced;
  if (report.prepared.scene) json["quality"] = quality_json(job, report.prepared);
  for (const RenderedView& view : report.views) {
    json["views"].push_back({{"view", view.view},
                             {"file", view.file.filename().string()},
                             {"was_there", view.was_there},
                             {"maps_s", view.map_seconds},
                             {"lights_s", view.statistics.seconds},
                             {"paths", view.statistics.paths},
                             {"closest_hit_rays", view.statistics.closest_hit_rays},
                             {"shadow_rays", view.statistics.shadow_rays},
                             {"walks", view.statistics.walks},
                             {"walk_segments", view.statistics.walk_segments},
                             {"walk_leaks", view.statistics.walk_leaks},
                             {"nonfinite_left_out", view.statistics.nonfinite}});
    if (job.goal && !view.was_there) json["views"].back()["error"] = error_json(*job.goal, view.error);
  }
  write_file_atomically(job.output / "render.json", json.dump(2) + "\n");
}

/// Builds what the quality asks for and says what it leaves out. Pilots look at three of the job's views.
PreparedScene prepare(const RenderJob& job, const Model& model, const std::vector<Environment>& environments,
                      const Camera& camera, RenderReport& report) {
  const auto start = Clock::now();
  const std::vector<int>& views = job.views.indices;
  std::vector<QualityView> looked_at;
  for (size_t k = 0; k < std::min<size_t>(3, views.size()); ++k)
    looked_at.push_back(
        {camera, turn_of_view(views[k * views.size() / std::min<size_t>(3, views.size())], job.views.count)});
  PreparedScene prepared =
      prepare_scene(model, environments, job.points, looked_at, static_cast<int>(views.size()), job.settings,
                    job.quality, job.tolerance);
  for (const Omission& o : prepared.tried)
    spdlog::info("{} {}: changes the image by {:.2g} (98 % sure: {:.2g} to {:.2g})",
                 o.is_left_out ? "left out:" : "kept: without", o.what, o.error, o.low, o.high);
  if (job.quality == Quality::kAuto)
    spdlog::info("all together change it by {:.2g} at most; tolerance {:.2g}", prepared.error_high,
                 job.tolerance);
  report.load_seconds += seconds_since(start);
  return prepared;
}

/// To the goal, with a warning if it is not reached. Progress counts pixels: as many are done as the share of
/// the goal's paths that the error says.
std::vector<SampleLight> render_goal(const Scene& scene, const LightSet& lights, const Camera& camera,
                                     double turn_rad, const RenderSettings& settings, const ErrorGoal& goal,
                                     RenderedView& rendered, Progress& progress) {
  const size_t pixels = static_cast<size_t>(settings.size_px) * settings.size_px;
  size_t shown = 0;
  const auto show = [&](double share) {
    const size_t done = std::max(shown, static_cast<size_t>(share * static_cast<double>(pixels)));
    progress.add(done - shown);
    shown = done;
  };
  std::vector<SampleLight> images = render_to_error(
      scene, lights, camera, turn_rad, settings, goal, rendered.error, &rendered.statistics,
      [](size_t) { throw_if_interrupted(); },
      [&](double error) {
        progress.note(fmt::format("error {:.3g} of {:.3g}", error, goal.relative_error));
        show(std::isfinite(error) ? std::min(1.0, std::pow(goal.relative_error / error, 2)) : 0);
      });
  show(1);
  const RegionError* worst = rendered.error.worst();
  if (!rendered.error.met && worst)
    spdlog::warn(
        "view {}: the error is {:.2f} times the goal of {:.3g} ({} under {}) after {:.0f} paths a pixel; for "
        "less, raise --max-spp",
        rendered.view, rounded_up(worst->relative_error / goal.relative_error), goal.relative_error,
        worst->region, worst->light, rendered.error.spp);
  return images;
}

std::string view_name(int view) {
  std::string digits = std::to_string(view);
  return "view_" + std::string(digits.size() < 3 ? 3 - digits.size() : 0, '0') + digits;
}

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
      views.indices.push_back(index);
    }
  return views;
}

PointLight parse_point_light(const std::string& text, size_t index) {
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
  const std::string model_sha256 = sha256_of_file(job.model_folder / "model.xml");
  std::error_code error;
  fs::create_directories(job.output / "previews", error);
  if (error)
    throw InputError(job.output.string(), "", "cannot be created: " + error.message(), "choose another -o");

  RenderReport report;
  report.subsurface_replaced = !job.settings.subsurface && has_subsurface(model);
  const Camera camera = fit_camera(model.positions_cm);
  report.load_seconds = seconds_since(start);

  const size_t pixels = static_cast<size_t>(job.settings.size_px) * job.settings.size_px;
  Progress progress("rendering", job.views.indices.size() * pixels, job.quiet);
  for (const int view : job.views.indices) {
    RenderedView rendered;
    rendered.view = view;
    rendered.file = job.output / (view_name(view) + ".exr");
    const ExrAttributes attributes = attributes_of(job, model, model_sha256, environments, camera, view);
    if (is_done(rendered.file, attributes)) {
      rendered.was_there = true;
      progress.add(pixels);
    } else {
      if (!report.prepared.scene) report.prepared = prepare(job, model, environments, camera, report);
      const PreparedScene& prepared = report.prepared;
      RenderSettings settings = prepared.settings_for(job.settings);
      settings.seed = seed_of_view(job.settings.seed, model.name, view, job.views.count);
      const double turn_rad = turn_of_view(view, job.views.count);
      const auto map_start = Clock::now();
      Sample sample =
          render_maps(*prepared.scene, camera, turn_rad, settings, [](size_t) { throw_if_interrupted(); });
      rendered.map_seconds = seconds_since(map_start);
      sample.lights = job.goal ? render_goal(*prepared.lit, *prepared.lights, camera, turn_rad, settings,
                                             *job.goal, rendered, progress)
                               : render_lights(*prepared.lit, *prepared.lights, camera, turn_rad, settings,
                                               &rendered.statistics, [&](size_t n) {
                                                 throw_if_interrupted();
                                                 progress.add(n);
                                               });
      if (rendered.statistics.nonfinite > 0)
        spdlog::warn("view {}: {} contributions were NaN or infinite and left out", view,
                     rendered.statistics.nonfinite);
      sample.attributes = attributes;
      add_needs(job, prepared, sample.attributes);
      if (job.goal) add_reached(rendered.error, sample.attributes);
      write_previews(job.output / "previews", view_name(view), sample);
      write_sample(rendered.file, sample);
    }
    report.views.push_back(rendered);
  }
  write_render_json(job, report);
  return report;
}

}  // namespace ohb
