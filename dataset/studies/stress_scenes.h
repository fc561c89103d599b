// The scenes of the stress catalogue, each with one parameter.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dataset/model/camera.h"
#include "dataset/model/environment.h"
#include "dataset/model/model.h"
#include "renderer/render.h"

namespace ohb::studies {

struct StressScene {
  Model model;
  Environment environment;
  Camera camera;
  bool subsurface = false;
};

/// The scene of that name (assets/stress/catalogue.json says what each is) at a parameter's value. Throws
/// InputError for a name that there is not.
StressScene stress_scene(const std::string& name, double at);

}  // namespace ohb::studies
