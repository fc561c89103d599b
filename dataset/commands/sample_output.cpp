#include "dataset/commands/sample_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>

#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"
#include "dataset/model/sample_listing.h"

namespace ohb::commands {
namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;
namespace {

constexpr const char* kMend = "add --overwrite to replace them, or choose another -o";

std::string shortest(double value) {
  char buffer[64];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

const char* quality_name(renderer::Quality quality) {
  return quality == renderer::Quality::kAuto   ? "auto"
         : quality == renderer::Quality::kFast ? "fast"
                                               : "reference";
}

void add_lights(const RenderJob& job, const std::vector<Environment>& environments, ExrAttributes& a) {
  for (const Environment& environment : environments)
    a.emplace_back("ohb:environment." + environment.name, environment.sha256);
  for (const renderer::PointLight& light : job.points)
    a.emplace_back("ohb:point." + light.name,
                   shortest(light.position_cm.x) + "," + shortest(light.position_cm.y) + "," +
                       shortest(light.position_cm.z) + "," + shortest(light.intensity));
}

/// In words, what differs first; "" if nothing does. Hashes say nothing to people.
std::string first_difference(const ExrAttributes& there, const ExrAttributes& now) {
  const std::map<std::string, std::string> before(there.begin(), there.end()), after(now.begin(), now.end());
  const auto said = [](const std::string& name, const std::string& was, const std::string& is) {
    const std::string word = name.substr(name.find(':') + 1);
    if (name == "ohb:modelHash") return std::string("the model is another one, or was baked again");
    if (name.rfind("ohb:environment.", 0) == 0)
      return word + (was.empty()  ? " was not among the lights"
                     : is.empty() ? " was among the lights, and is not now"
                                  : " is another picture");
    return fmt::format("{} is {} there and {} now", word, was.empty() ? "not set" : "'" + was + "'",
                       is.empty() ? "not set" : "'" + is + "'");
  };
  for (const auto& [name, value] : now) {
    const auto found = before.find(name);
    if (found == before.end()) return said(name, "", value);
    if (found->second != value) return said(name, found->second, value);
  }
  for (const auto& [name, value] : there)
    if (after.count(name) == 0) return said(name, value, "");
  return "";
}

std::vector<std::string> view_files(const fs::path& folder) {
  std::vector<std::string> names;
  if (fs::is_directory(folder))
    for (const auto& entry : fs::directory_iterator(folder))
      if (is_view_file(entry.path())) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// Throws InputError if the views there are of other settings, or of settings that nobody noted.
void check_settings(const fs::path& folder, const ExrAttributes& settings, const std::string& identity) {
  const std::optional<SampleListing> there = read_sample_listing(folder);
  if (there && there->identity != identity)
    throw InputError(folder.string(), "",
                     "holds samples of other settings: " + first_difference(there->settings, settings),
                     kMend);
  if (there) return;
  const std::vector<std::string> views = view_files(folder);
  const std::string found = fs::exists(folder / "render.json") ? "render.json"
                            : views.empty()                    ? ""
                                                               : views[0];
  if (!found.empty())
    throw InputError(
        folder.string(), "",
        "holds " + found + ", and nothing says by which settings (an older version, another program)", kMend);
}

json error_json(const renderer::ErrorGoal& goal, const renderer::ErrorReport& error) {
  json result = {{"goal", goal.relative_error}, {"met", error.met}, {"spp", error.spp}};
  for (const renderer::RegionError& e : error.errors)
    result["reached"].push_back({{"light", e.light},
                                 {"region", e.region},
                                 {"pixels", e.pixels},
                                 {"relative_error", e.relative_error}});
  return result;
}

ordered_json view_json(const RenderedView& view, const RenderJob& job) {
  ordered_json row = {{"view", view.view},
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
                      {"nonfinite_left_out", view.statistics.nonfinite}};
  if (job.goal && !view.was_there) row["error"] = error_json(*job.goal, view.error);
  return row;
}

}  // namespace

ExrAttributes settings_of(const RenderJob& job, const std::string& human, const std::string& model_identity,
                          const std::vector<Environment>& environments, const Camera& camera) {
  const renderer::RenderSettings& s = job.settings;
  // What people ask about first comes first: differences are told in this order.
  ExrAttributes a = {
      {"ohb:human", human},
      {"ohb:modelHash", model_identity},
      {"ohb:size_px", std::to_string(s.size_px)},
      {"ohb:viewCount", std::to_string(job.views.count)},
      {job.goal ? "ohb:maxSpp" : "ohb:spp", std::to_string(job.goal ? job.goal->max_spp : s.spp)},
      {"ohb:seed", std::to_string(s.seed)},
      {"ohb:sampling", s.adaptive ? "adaptive" : "even"},
      {"ohb:maxBounces", std::to_string(s.max_bounces)},
      {"ohb:mapGrid", std::to_string(s.map_grid)},
      {"ohb:subsurface", s.subsurface ? "random walk" : "replaced by diffuse"},
      {"ohb:quality", quality_name(job.quality)},
  };
  if (job.quality == renderer::Quality::kAuto) a.emplace_back("ohb:tolerance", shortest(job.tolerance));
  if (job.goal) a.emplace_back("ohb:error", shortest(job.goal->relative_error));
  // Samples of v1 keep the attributes that they had before there was another.
  if (s.shading == renderer::ShadingModel::kV2)
    a.emplace_back("ohb:shadingModel", "Principled v2, Blender 4.5");
  add_lights(job, environments, a);
  a.insert(a.end(),
           {{"ohb:toolVersion", OHB_VERSION},
            {"ohb:unit", "cm"},
            {"ohb:cameraCenterY_cm", shortest(camera.center_y_cm)},
            {"ohb:cameraDistance_cm", shortest(camera.distance_cm)},
            {"ohb:cameraHalfWidth", shortest(camera.half_width)},
            {"ohb:displacementRange_cm", shortest(camera.half_frame_cm())},
            {"ohb:conventions",
             "normal: camera space, +X right, +Y up, +Z to the viewer; specular: S, F0 = sRGB_to_linear(S); "
             "roughness: alpha = roughness^2; displacement: cm from the plane z = 0 towards the camera; "
             "relit: linear Rec. 709, premultiplied by mask"}});
  return a;
}

void add_needs(const RenderJob& job, const renderer::PreparedScene& prepared, ExrAttributes& attributes) {
  if (job.quality == renderer::Quality::kReference) return;
  const auto add = [&](const std::string& name, const std::string& value) {
    attributes.emplace_back("ohb:needs." + name, value);
  };
  const renderer::Needs& needs = prepared.needs;
  const auto limit = [](int value) {
    return value == renderer::Needs().map_px ? "all" : std::to_string(value);
  };
  add("subsurface", needs.subsurface ? "all" : "none");
  add("maxBounces", limit(needs.max_bounces));
  add("environment_px", limit(needs.environment_px));
  add("map_px", limit(needs.map_px));
  if (job.quality == renderer::Quality::kAuto) add("errorAtMost", fmt::format("{:.4g}", prepared.error_high));
}

void add_reached(const renderer::ErrorReport& error, ExrAttributes& attributes) {
  attributes.emplace_back("ohb:reached.spp", fmt::format("{:.1f}", error.spp));
  for (const renderer::RegionError& e : error.errors)
    attributes.emplace_back("ohb:reached.error." + e.light + "." + e.region,
                            fmt::format("{:.4g}", e.relative_error));
}

std::string view_name(int view) {
  std::string digits = std::to_string(view);
  return "view_" + std::string(digits.size() < 3 ? 3 - digits.size() : 0, '0') + digits;
}

json quality_json(const RenderJob& job, const renderer::PreparedScene& prepared) {
  const renderer::Needs& needs = prepared.needs;
  const auto limit = [](int value) { return value == renderer::Needs().map_px ? json() : json(value); };
  json result = {{"quality", quality_name(job.quality)},
                 {"subsurface", needs.subsurface},
                 {"max_bounces", limit(needs.max_bounces)},
                 {"environment_px", limit(needs.environment_px)},
                 {"map_px", limit(needs.map_px)}};
  if (job.quality != renderer::Quality::kAuto) return result;
  result["tolerance"] = job.tolerance;
  result["error_at_most"] = prepared.error_high;
  result["processor_time_of_pilots_to_reference"] = prepared.cpu_share;
  for (const renderer::Omission& o : prepared.tried)
    result["tried"].push_back({{"what", o.what},
                               {"left_out", o.is_left_out},
                               {"error", o.error},
                               {"low", o.low},
                               {"high", o.high}});
  return result;
}

SampleOutput::SampleOutput(const fs::path& folder, ExrAttributes settings, bool overwrites)
    : folder_(folder),
      settings_(std::move(settings)),
      identity_(identity_of(settings_)),
      overwrites_(overwrites) {
  for (const auto& [name, value] : settings_)
    if (name == "ohb:viewCount") view_count_ = std::stoi(value);
  claim_folder(folder, "samples");
  try {
    check_settings(folder, settings_, identity_);
  } catch (const InputError&) {
    if (!overwrites) throw;
    remove_views();
  }
  if (read_sample_listing(folder)) {
    json_ = parse_json<ordered_json>(read_file(folder / "render.json"), "render.json", kListingLimits);
    ordered_json views = ordered_json::array();
    for (ordered_json& row : json_["views"])
      if (fs::exists(folder / row["file"].get<std::string>())) {
        row["was_there"] = true;
        views.push_back(row);
      }
    json_["views"] = views;
  } else {
    json_["identity"] = identity_;
    for (const auto& [name, value] : settings_) json_["settings"][name] = value;
    json_["views"] = ordered_json::array();
  }
  make_folders(folder / "previews");
  write();
}

// render.json goes last: as long as it is there, what it says of the rest is true.
void SampleOutput::remove_views() const {
  std::vector<fs::path> files;
  for (const std::string& name : view_files(folder_)) files.push_back(folder_ / name);
  if (fs::is_directory(folder_ / "previews"))
    for (const auto& entry : fs::directory_iterator(folder_ / "previews")) {
      const std::string name = entry.path().filename().string();
      if (is_view_file(name.substr(0, name.find('.')) + ".exr") && entry.path().extension() == ".png")
        files.push_back(entry.path());
    }
  files.push_back(folder_ / "render.json");
  std::error_code error;
  for (const fs::path& file : files)
    if (fs::remove(file, error); error) throw_write_error(file, error.value());
}

fs::path SampleOutput::file_of(int view) const {
  return folder_ / (view_name(view) + ".exr");
}

ExrAttributes SampleOutput::attributes_of(int view) const {
  ExrAttributes attributes = settings_;
  attributes.emplace_back("ohb:view", std::to_string(view));
  attributes.emplace_back("ohb:turn_deg", shortest(360.0 * view / view_count_));
  attributes.emplace_back("ohb:identity", identity_);
  return attributes;
}

bool SampleOutput::is_done(int view) const {
  const fs::path file = file_of(view);
  if (!fs::exists(file)) return false;
  std::string fault = "is of other settings than the folder";
  try {
    const ExrAttributes found = read_sample(file).attributes, wanted = attributes_of(view);
    const auto says = [&](const auto& attribute) {
      return std::find(found.begin(), found.end(), attribute) != found.end();
    };
    // Both hold the identity, so that an attribute more in the file is one that rendering found out.
    if (std::all_of(wanted.begin(), wanted.end(), says)) return true;
  } catch (const InputError&) {
    fault = "is damaged";
  }
  // One of ours that was damaged later is rendered again; what this folder's jobs never wrote is somebody's.
  for (const auto& row : json_["views"])
    if (row["file"] == file.filename().string()) return false;
  if (!overwrites_)
    throw InputError(file.string(), "", fault + ", and no job of this folder wrote it",
                     "move it elsewhere, or add --overwrite to replace it");
  return false;
}

void SampleOutput::add(const RenderedView& view, const RenderJob& job, const RenderReport& report) {
  const std::string name = view.file.filename().string();
  ordered_json views = ordered_json::array();
  bool is_known = false;
  for (const ordered_json& row : json_["views"]) {
    if (row["file"] == name) {
      is_known = view.was_there;
      if (!view.was_there) continue;
    }
    views.push_back(row);
  }
  if (!is_known) views.push_back(view_json(view, job));
  std::sort(views.begin(), views.end(),
            [](const ordered_json& a, const ordered_json& b) { return a["view"] < b["view"]; });
  json_["load_s"] = report.load_seconds;
  json_["subsurface_replaced_by_diffuse"] = report.subsurface_replaced;
  if (report.prepared.scene) json_["quality"] = quality_json(job, report.prepared);
  json_["views"] = views;
  if (!view.was_there || !is_known) write();
}

void SampleOutput::write() const {
  write_file_atomically(folder_ / "render.json", json_text(json_, 2) + "\n");
}

}  // namespace ohb::commands
