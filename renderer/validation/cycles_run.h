// Finds Blender and has it render a scene that write_cycles_scene wrote.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "dataset/model/blender.h"
#include "dataset/model/image.h"
#include "renderer/render.h"

namespace ohb::validation {

/// Asks the program (empty: `blender` in PATH) for its version. Throws InputError if it cannot be started
/// or is not the version whose Cycles the model equals: 3.4 for v1, 4.5 for v2.
Blender find_blender(const std::filesystem::path& program,
                     renderer::ShadingModel shading = renderer::ShadingModel::kV1);

/// The same for a virtual environment that has Blender as the Python module bpy.
Blender find_bpy(const std::filesystem::path& environment, renderer::ShadingModel shading);

/// Makes `environment` and installs the module of Blender 4.5 there, from PyPI (about 400 MB; needs Python
/// 3.11). Does nothing where a module of that version is. Throws InputError if it cannot; what was there
/// stays then, and what was not is removed.
void install_bpy(const std::filesystem::path& environment);

/// One property: what was asked for and what Blender held after the last render, as JSON text.
struct CyclesSetting {
  std::string name, wanted, found;
  bool same = false;
};

struct CyclesRender {
  uint32_t seed = 0;
  double wall_s = 0, cpu_s = 0;  // of this image alone; loading is apart
  Image rgba;                    // 4, linear Rec. 709, premultiplied, alpha = coverage
};

struct CyclesRun {
  std::string version;                            // Blender's
  double load_s = 0, load_cpu_s = 0;              // scene, trees and tables, with one sample a pixel
  std::vector<std::vector<CyclesRender>> passes;  // of the scene, in its order; in each one a seed
  std::vector<CyclesSetting> settings;
};

/// Renders folder/scene.json with blender_addon/validation_scene.py; `done` hears how many
/// images are done, parts of one included.
/// threads 0: all. The renders stay in folder/renders. Throws InputError with Blender's last line if it
/// fails.
CyclesRun run_cycles(const Blender& blender, const std::filesystem::path& folder, int threads,
                     const std::function<void(double images)>& done = nullptr);

}  // namespace ohb::validation
