#include "renderer/validation/cycles_run.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"

namespace ohb::validation {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

/// The version whose Cycles a model equals.
struct KnownBlender {
  int major, minor;
  std::string mend;
};
KnownBlender known_blender(renderer::ShadingModel shading) {
  if (shading == renderer::ShadingModel::kV1)
    return {3, 4, "install Debian 12's package (apt install blender) or name Blender 3.4 with --blender"};
  return {
      4, 5,
      "name Blender 4.5 with --blender, or a folder with --bpy and let --install-bpy fetch it as a module"};
}

Blender checked(const Blender& blender, const KnownBlender& known) {
  if (blender.major != known.major || blender.minor != known.minor)
    throw InputError(blender.program.string(), "",
                     "is Blender " + blender.version + "; this model equals Cycles of Blender " +
                         std::to_string(known.major) + "." + std::to_string(known.minor),
                     known.mend);
  return blender;
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

/// From our script's lines, "progress 3 16", and Blender's own of the image under way, "... | Sample 12/128".
double images_done(const std::string& line, size_t& finished) {
  size_t images = 0, total = 0, sample = 0, samples = 0;
  if (std::sscanf(line.c_str(), "progress %zu %zu", &images, &total) == 2) finished = images;
  const size_t at = line.rfind("Sample ");
  const bool is_inside = at != std::string::npos &&
                         std::sscanf(line.c_str() + at, "Sample %zu/%zu", &sample, &samples) == 2 &&
                         sample < samples;
  return static_cast<double>(finished) + (is_inside ? static_cast<double>(sample) / samples : 0);
}

void run_or_throw(const std::vector<std::string>& arguments, const std::string& mend) {
  const ProcessResult result = run_process(arguments, {}, nullptr);
  if (result.exit_code != 0)
    throw InputError(arguments[0], "", "failed: " + reason_of(result.last_lines), mend);
}

bool is_full_disk(const std::vector<std::string>& lines) {
  return std::any_of(lines.begin(), lines.end(), [](const std::string& line) {
    return line.find(std::strerror(ENOSPC)) != std::string::npos;
  });
}

CyclesRun read_report(const fs::path& renders) {
  const json report = read_json(renders / "report.json");
  CyclesRun run;
  run.version = report.at("versions").at("blender");
  run.load_s = report.at("build_s").get<double>() + report.at("load_s").get<double>();
  run.load_cpu_s = report.at("load_cpu_s");
  for (const json& row : report.at("settings"))
    run.settings.push_back(
        {row.at("name"), json_text(row.at("wanted")), json_text(row.at("found")), row.at("same")});
  for (const json& pass : report.at("passes")) {
    run.passes.emplace_back();
    for (const json& row : pass) run.passes.back().push_back(read_render(renders, row));
  }
  return run;
}

}  // namespace

Blender find_blender(const fs::path& program, renderer::ShadingModel shading) {
  const KnownBlender known = known_blender(shading);
  return checked(ask_blender(program, known.mend), known);
}

Blender find_bpy(const fs::path& environment, renderer::ShadingModel shading) {
  const KnownBlender known = known_blender(shading);
  return checked(ask_bpy(environment, known.mend), known);
}

void install_bpy(const fs::path& environment) {
  // Pinned: the newest of the long-term version when this was written.
  constexpr const char* kPackage = "bpy==4.5.15";
  if (fs::exists(environment)) {
    try {
      find_bpy(environment, renderer::ShadingModel::kV2);
      return;
    } catch (const InputError&) {
      throw InputError(environment.string(), "", "is there, and does not have Blender 4.5 as a module",
                       "name a folder that is not there yet");
    }
  }
  try {
    std::fprintf(stderr, "fetching %s into %s\n", kPackage, environment.c_str());
    run_or_throw({"python3.11", "-m", "venv", environment.string()},
                 "install Python 3.11 with its venv module (apt install python3.11-venv): "
                 "Blender 4.5 has no module for others");
    run_or_throw({(environment / "bin/pip").string(), "install", "--disable-pip-version-check", kPackage},
                 "check the network, or install bpy 4.5 in a Python 3.11 environment yourself");
    find_bpy(environment, renderer::ShadingModel::kV2);
  } catch (...) {
    fs::remove_all(environment);
    throw;
  }
}

CyclesRun run_cycles(const Blender& blender, const fs::path& folder, int threads,
                     const std::function<void(double images)>& done) {
  // Its temporary files and user settings stay inside the folder.
  const fs::path inside = folder / "blender";
  size_t finished = 0;
  fs::create_directories(inside);
  const ProcessResult result = run_in_blender(blender, "blender_addon/validation_scene.py",
                                              {(folder / "scene.json").string(), std::to_string(threads)},
                                              threads, inside, [&](const std::string& line) {
                                                if (done) done(images_done(line, finished));
                                              });
  fs::remove_all(inside);
  if (result.exit_code != 0 && is_full_disk(result.last_lines))
    throw TryAgainError(folder.string(), "the disk is full", "free some space and run the command again");
  if (result.exit_code != 0) throw_blender_failure(blender, result);
  std::string fault;
  try {
    return read_report(folder / "renders");
  } catch (const InputError& error) {
    fault = error.what();
  } catch (const json::exception& error) {
    fault = error.what();
  }
  // Blender says nothing of a disk that is full while it writes a picture.
  throw TryAgainError(folder.string(), "Blender did not write its renders whole: " + fault,
                      "free some space and run the command again");
}

}  // namespace ohb::validation
