#include "learner/relight.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <stdexcept>

#include "dataset/model/atomic_file.h"
#include "dataset/model/blender.h"
#include "dataset/model/environment.h"
#include "dataset/model/error.h"
#include "dataset/model/image.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/json_text.h"
#include "dataset/model/progress.h"
#include "dataset/model/temporary.h"
#include "learner/output_file.h"

namespace ohb::learner {
namespace fs = std::filesystem;
namespace {

constexpr int kOldestMajor = 3, kOldestMinor = 4;
constexpr const char* kMend =
    "install it (apt install blender) or name Blender 3.4 or a later one with --blender";
// How relight.py begins the lines that are for the user.
const std::string kVoice = "relight: ", kWarning = "warning: ", kUsage = "error: ";

/// The files that a maps folder is made of: those of its marker, and those that maps.json names.
std::vector<fs::path> files_of_maps(const fs::path& maps) {
  const fs::path folder = fs::is_directory(maps) ? maps : folder_of(maps);
  std::vector<fs::path> files = {folder / "maps.json"};
  if (!fs::is_regular_file(files[0])) return files;
  const nlohmann::json json = read_json(files[0]);
  if (json.is_object() && json.contains("maps") && json["maps"].is_object())
    for (const auto& [name, map] : json["maps"].items())
      if (map.is_object() && map.contains("file") && map["file"].is_string())
        files.push_back(folder / map["file"].get<std::string>());
  return files;
}

void check_picture(const fs::path& picture, const fs::path& output, const nlohmann::json& report) {
  std::string fault;
  try {
    const Image image = read_image(picture);
    if (report.at("size_px") != nlohmann::json({image.width_px, image.height_px}))
      fault = "is of another size";
  } catch (const InputError& error) {
    fault = error.what();
  }
  if (!fault.empty())
    throw TryAgainError(output.string(), "Blender did not write the picture whole (" + fault + ")",
                        "free some space and run the command again");
}

bool take_prefix(std::string& text, const std::string& prefix) {
  if (text.compare(0, prefix.size(), prefix) != 0) return false;
  text.erase(0, prefix.size());
  return true;
}

Blender blender_of(const fs::path& program) {
  const Blender blender = ask_blender(program, kMend);
  if (std::pair(blender.major, blender.minor) < std::pair(kOldestMajor, kOldestMinor))
    throw InputError(blender.program.string(), "",
                     "is Blender " + blender.version + "; the add-on needs 3.4 or later", kMend);
  return blender;
}

/// Each value in one word with its option, so that a minus sign does not look like another option.
std::vector<std::string> arguments_of(const RelightOptions& o, const fs::path& report) {
  std::vector<std::string> arguments;
  const auto add = [&](const std::string& name, const std::string& value) {
    arguments.push_back("--" + name + "=" + value);
  };
  if (!o.environment.empty()) add("environment", o.environment.string());
  for (const std::string& point : o.points) add("point", point);
  for (const std::string& edit : o.edits) add("edit", edit);
  add("rotation", fmt::format("{}", o.rotation_deg));
  add("strength", fmt::format("{}", o.strength));
  add("subsurface-scale", fmt::format("{}", o.subsurface_scale));
  if (o.size_px > 0) add("size", std::to_string(o.size_px));
  add("spp", std::to_string(o.spp));
  add("seed", std::to_string(o.seed));
  add("background", o.background);
  add("report", report.string());
  add("output", o.output.string());
  arguments.insert(arguments.end(), {"--", o.maps.string()});
  return arguments;
}

/// What relight.py says while it runs.
class Listener {
 public:
  void hear(const std::string& line) {
    // Not at the line's start only: Blender's own text may stand before it without a line break.
    if (const size_t at = line.find(kVoice); at != std::string::npos) {
      std::string words = line.substr(at + kVoice.size());
      if (take_prefix(words, kWarning))
        spdlog::warn("{}", words);
      else
        error = words;
    }
    const size_t at = line.rfind("Sample ");
    size_t done = 0, total = 0;
    if (at == std::string::npos || std::sscanf(line.c_str() + at, "Sample %zu/%zu", &done, &total) != 2)
      return;
    if (!progress_)
      progress_.emplace("rendering in Blender", total);  // a refusal comes before and shows no bar
    if (done > done_) progress_->add(done - done_);
    done_ = std::max(done_, done);
  }

  std::string error;  // the last line that is no warning

 private:
  std::optional<Progress> progress_;
  size_t done_ = 0;
};

[[noreturn]] void fail(const Blender& blender, const ProcessResult& result, std::string words) {
  take_prefix(words, kUsage);
  if (result.exit_code == kExitBadInput && !words.empty()) throw InputError("", "", words, "");
  if (result.exit_code == kExitTryAgain && !words.empty()) throw TryAgainError("", words, "");
  for (const std::string& line : result.last_lines) std::fprintf(stderr, "%s\n", line.c_str());
  // 70: an exception that the script itself calls a bug.
  if (result.exit_code == kExitBug && !speaks_of_memory(reason_of(result.last_lines)))
    throw std::runtime_error(blender.program.string() + ": " + reason_of(result.last_lines));
  throw_blender_failure(blender, result);
}

/// The environment as `render` reads it, linear, turned and in its display window, in a file that any Blender
/// takes so. Throws InputError as read_environment.
fs::path linear_environment(const fs::path& environment, const fs::path& folder) {
  const Image radiance = read_environment(environment).radiance;
  write_exr(folder / "environment.exr", {{"map", {"R", "G", "B"}, ExrPart::Type::kFloat, radiance}}, {});
  return folder / "environment.exr";
}

}  // namespace

nlohmann::json relight(const RelightOptions& options) {
  const Blender blender = blender_of(options.blender);
  const fs::path output = followed(options.output);
  std::vector<fs::path> inputs = files_of_maps(options.maps);
  inputs.push_back(options.environment);
  check_output_file(output, inputs);
  sweep_leftovers(folder_of(output));
  // Beside the picture's place, so that it can be renamed into it.
  const LockedTemporary scratch(output, LockedTemporary::Kind::kFolder);
  const fs::path report_file = scratch.path() / "report.json",
                 picture = scratch.path() / ("picture" + output.extension().string());
  RelightOptions inside = options;
  inside.output = picture;
  if (!options.environment.empty())
    inside.environment = linear_environment(options.environment, scratch.path());
  Listener listener;
  const ProcessResult result =
      run_in_blender(blender, "blender_addon/relight.py", arguments_of(inside, report_file), options.threads,
                     scratch.path(), [&](const std::string& line) { listener.hear(line); });
  throw_if_interrupted();
  // Blender's words are of the temporary name.
  for (size_t at; (at = listener.error.find(picture.string())) != std::string::npos;)
    listener.error.replace(at, picture.string().size(), options.output.string());
  if (result.exit_code != 0) fail(blender, result, listener.error);
  nlohmann::json report = read_json(report_file);
  check_picture(picture, options.output, report);
  sync_path(picture, false);
  std::error_code error;
  hold_off_ending([&] { fs::rename(picture, output, error); });
  if (error) throw_write_error(options.output, error.value());
  sync_path(folder_of(output), true);
  report["output"] = fs::absolute(options.output).string();
  return report;
}

}  // namespace ohb::learner
