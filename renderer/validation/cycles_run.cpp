#include "renderer/validation/cycles_run.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "dataset/model/atomic_file.h"
#include "dataset/model/data_files.h"
#include "dataset/model/error.h"
#include "renderer/validation/process.h"

namespace ohb {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr const char* kKnownVersion = "3.4.";
constexpr const char* kMend =
    "install Debian 12's package (apt install blender) or name Blender 3.4 with --blender";

/// The last line that says what went wrong: a Python exception or an error of Blender's.
std::string reason_of(const std::vector<std::string>& lines) {
  for (auto line = lines.rbegin(); line != lines.rend(); ++line)
    if (line->find("rror: ") != std::string::npos && line->find("script failed") == std::string::npos)
      return *line;
  return lines.empty() ? "no output" : lines.back();
}

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
  Blender blender{program.empty() ? fs::path("blender") : program, ""};
  const std::string name = blender.program.string();
  ProcessResult result;
  try {
    result = run_process({name, "--version"}, {}, [&](const std::string& line) {
      char version[32];
      if (blender.version.empty() && std::sscanf(line.c_str(), "Blender %31s", version) == 1)
        blender.version = version;
    });
  } catch (const InputError&) {
    throw InputError(name, "", "Blender was not found there", kMend);
  }
  if (blender.version.empty()) throw InputError(name, "", "does not answer as Blender does", kMend);
  if (blender.version.compare(0, std::string(kKnownVersion).size(), kKnownVersion) != 0)
    throw InputError(name, "",
                     "is Blender " + blender.version + "; our renderer equals Cycles of Blender 3.4", kMend);
  return blender;
}

CyclesRun run_cycles(const Blender& blender, const fs::path& folder, int threads,
                     const std::function<void(size_t, size_t)>& done) {
  const std::vector<std::string> arguments = {blender.program.string(),
                                              "-b",
                                              "-noaudio",
                                              "--factory-startup",
                                              "-t",
                                              std::to_string(threads),
                                              "--python-exit-code",
                                              "1",
                                              "--python",
                                              program_file("blender_addon/validation_scene.py").string(),
                                              "--",
                                              (folder / "scene.json").string()};
  // Its temporary files and user settings stay inside the folder.
  const std::string inside = fs::absolute(folder / "blender").string();
  fs::create_directories(inside);
  const ProcessResult result = run_process(
      arguments, {{"TMPDIR", inside}, {"BLENDER_USER_CONFIG", inside}, {"BLENDER_USER_SCRIPTS", inside}},
      [&](const std::string& line) {
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
