#include "learner/torchscript.h"

#include <torch/csrc/jit/frontend/tracer.h>
#include <torch/script.h>

#include <algorithm>
#include <sstream>

#include "dataset/model/atomic_file.h"
#include "dataset/model/json_text.h"
#include "learner/data.h"
#include "learner/output_file.h"

namespace ohb::learner {
namespace {

using torch::Tensor;

/// The networks' parameters, which the recorder looks for by their tensors.
torch::jit::Module module_of(const Estimator& estimator) {
  torch::jit::Module module("HumanMaterial");
  for (const Network& network : estimator.networks())
    for (const auto& parameter : network.module().named_parameters()) {
      std::string name = std::string(name_of(network.task)) + "_" + parameter.key();
      std::replace(name.begin(), name.end(), '.', '_');
      module.register_parameter(name, parameter.value(), /*is_buffer=*/false);
    }
  return module;
}

nlohmann::json description_of(const ScriptReport& report) {
  nlohmann::json outputs;
  for (const LearnedMap& map : kMaps)
    outputs[map.name] = map.tensor == &MaterialMaps::displacement
                            ? "halves of the frame's width from the plane z = 0, positive towards the camera"
                        : map.tensor == &MaterialMaps::normal
                            ? "camera space: +X right, +Y up, +Z to the viewer"
                        : map.tensor == &MaterialMaps::diffuse ? "linear Rec. 709"
                                                               : map.convention;
  return {{"format", "humanmaterial.torchscript"},
          {"version", 1},
          {"program", "humanmaterial " OHB_VERSION},
          {"size_px", report.size_px},
          {"picture", "(B, 3, size, size): sRGB in [0, 1], times the mask"},
          {"mask", "(B, 1, size, size): share of the pixel that is covered"},
          {"maps", outputs}};
}

}  // namespace

ScriptReport write_torchscript(const Estimator& estimator, const std::filesystem::path& file) {
  namespace jit = torch::jit;
  check_output_file(file, estimator.files());
  const torch::NoGradGuard no_gradients;
  ScriptReport report;
  report.size_px = estimator.header().at("size_px");
  jit::Module module = module_of(estimator);
  for (const auto& parameter : module.parameters()) report.parameters += parameter.numel();

  const auto estimate = [&](jit::Stack inputs) -> jit::Stack {
    const MaterialMaps maps =
        estimator.estimate(network_input(inputs.at(0).toTensor(), inputs.at(1).toTensor()));
    c10::Dict<std::string, Tensor> named;
    for (const LearnedMap& map : kMaps) named.insert(map.name, maps.*map.tensor);
    return {named};
  };
  const jit::Stack example = {torch::full({1, 3, report.size_px, report.size_px}, 0.5f),
                              torch::ones({1, 1, report.size_px, report.size_px})};
  const std::shared_ptr<jit::Graph> graph =
      jit::tracer::trace(example, estimate, [](const torch::autograd::Variable&) { return ""; },
                         /*strict=*/false,
                         /*force_outplace=*/false, &module, {"picture", "mask"})
          .first->graph;
  const c10::QualifiedName name(*module.type()->name(), "forward");
  module.type()->addMethod(module._ivalue()->compilation_unit()->create_function(name, graph));
  // To a file libtorch would write the file's name, here a temporary one, into what it holds.
  std::ostringstream bytes;
  module.save(bytes, {{"humanmaterial.json", json_text(description_of(report), 2) + "\n"}});
  write_file_atomically(file, bytes.str());
  return report;
}

}  // namespace ohb::learner
