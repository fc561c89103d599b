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
#include "dataset/model/interrupt.h"
#include "dataset/model/json_text.h"
#include "dataset/model/progress.h"

namespace ohb {
namespace fs = std::filesystem;
namespace {

constexpr int kOldestMajor = 3, kOldestMinor = 4;
constexpr const char* kMend =
    "install it (apt install blender) or name Blender 3.4 or a later one with --blender";
// How relight.py begins the lines that are for the user.
const std::string kVoice = "relight: ", kWarning = "warning: ", kUsage = "error: ";

/// A new folder below the system's temporary folder, removed with everything in it.
class Scratch {
 public:
  Scratch() {
    std::string name = (fs::temp_directory_path() / "humanmaterial-XXXXXX").string();
    if (!::mkdtemp(name.data()))
      throw TryAgainError(fs::temp_directory_path().string(), "no folder can be made there",
                          "free some space, or set TMPDIR to a folder that can be written to");
    path_ = name;
    unfinished_.emplace(path_);
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
  std::optional<Unfinished> unfinished_;
};

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

nlohmann::json relight(const RelightOptions& given) {
  const Blender blender = blender_of(given.blender);
  const Scratch scratch;
  const fs::path report = scratch.path() / "report.json";
  RelightOptions options = given;
  if (!given.environment.empty()) options.environment = linear_environment(given.environment, scratch.path());
  Listener listener;
  const ProcessResult result =
      run_in_blender(blender, "blender_addon/relight.py", arguments_of(options, report), options.threads,
                     scratch.path(), [&](const std::string& line) { listener.hear(line); });
  throw_if_interrupted();
  if (result.exit_code != 0) fail(blender, result, listener.error);
  return read_json(report);
}

}  // namespace ohb
