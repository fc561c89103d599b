#include "renderer/validation/cycles_run.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"

namespace ohb {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr int kKnownMajor = 3, kKnownMinor = 4;
constexpr const char* kMend =
    "install Debian 12's package (apt install blender) or name Blender 3.4 with --blender";

/// One image, the sum of the files of its boxes.
CyclesRender read_render(const fs::path& renders, const json& row) {
  CyclesRender render{row.at("seed"), row.at("wall_s"), row.at("cpu_s"), {}};
  for (const std::string file : row.at("files")) {
    const Image image = read_image(renders / file);
    if (render.rgba.values.empty()) {
      render.rgba = image;
      continue;
    }
    for (size_t i = 0; i < image.values.size(); ++i) render.rgba.values[i] += image.values[i];
  }
  return render;
}

CyclesRun read_report(const fs::path& renders) {
  const json report = json::parse(read_file(renders / "report.json"));
  CyclesRun run;
  run.version = report.at("versions").at("blender");
  run.load_s = report.at("build_s").get<double>() + report.at("load_s").get<double>();
  run.load_cpu_s = report.at("load_cpu_s");
  for (const json& row : report.at("settings"))
    run.settings.push_back({row.at("name"), row.at("wanted").dump(), row.at("found").dump(), row.at("same")});
  for (const json& pass : report.at("passes")) {
    run.passes.emplace_back();
    for (const json& row : pass) run.passes.back().push_back(read_render(renders, row));
  }
  return run;
}

}  // namespace

Blender find_blender(const fs::path& program) {
  const Blender blender = ask_blender(program, kMend);
  if (blender.major != kKnownMajor || blender.minor != kKnownMinor)
    throw InputError(blender.program.string(), "",
                     "is Blender " + blender.version + "; our renderer equals Cycles of Blender 3.4", kMend);
  return blender;
}

CyclesRun run_cycles(const Blender& blender, const fs::path& folder, int threads,
                     const std::function<void(size_t, size_t)>& done) {
  // Its temporary files and user settings stay inside the folder.
  const fs::path inside = folder / "blender";
  fs::create_directories(inside);
  const ProcessResult result =
      run_in_blender(blender, "blender_addon/validation_scene.py", {(folder / "scene.json").string()},
                     threads, inside, [&](const std::string& line) {
                       size_t rendered = 0, total = 0;
                       if (done && std::sscanf(line.c_str(), "progress %zu %zu", &rendered, &total) == 2)
                         done(rendered, total);
                     });
  fs::remove_all(inside);
  if (result.exit_code > 128)
    throw TryAgainError(blender.program.string(),
                        "was ended by signal " + std::to_string(result.exit_code - 128),
                        "run the command again, with a smaller --size if memory was short");
  if (result.exit_code != 0)
    throw InputError(
        blender.program.string(), "",
        "stopped with code " + std::to_string(result.exit_code) + " (" + reason_of(result.last_lines) + ")",
        "check that it renders by itself");
  return read_report(folder / "renders");
}

}  // namespace ohb
