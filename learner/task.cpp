#include "learner/task.h"

#include "dataset/model/error.h"
#include "learner/chunked_loss.h"
#include "learner/counts.h"
#include "learner/oracle.h"

namespace ohb::learner {
namespace {

using torch::Tensor;

constexpr double kGeometrySpecular = 0.5;
constexpr double kAlbedoRoughness = 0.8, kAlbedoSpecular = 0.03;

Tensor encoded_geometry(const MaterialMaps& maps) {
  return torch::cat({(maps.normal + 1) / 2, 0.5 + maps.displacement / 2}, 1);
}

Tensor encoded_rss(const MaterialMaps& maps) {
  std::vector<Tensor> channels;
  for (const LearnedMap& map : kMaps)
    if (is_of_rss(map)) channels.push_back(maps.*map.tensor);
  return torch::cat(channels, 1);
}

void set_geometry(MaterialMaps& maps, const Tensor& output, int64_t at) {
  maps.normal = unit_normals(2 * output.slice(1, at, at + 3) - 1);
  maps.displacement = 2 * output.slice(1, at + 3, at + 4) - 1;
}

void set_rss(MaterialMaps& maps, const Tensor& output, int64_t at) {
  for (const LearnedMap& map : kMaps)
    if (is_of_rss(map)) maps.*map.tensor = output.slice(1, at, at + 1), ++at;
}

/// The rss channels, which are last, of absolute differences in equal units; the first (roughness) keeps its
/// weight.
Tensor with_balanced_rss(const Tensor& difference) {
  std::vector<double> spans;
  for (const LearnedMap& map : kMaps)
    if (is_of_rss(map)) spans.push_back(map.span);
  const int64_t others = difference.size(1) - rss_channels();
  const Tensor span = torch::tensor(spans, difference.options());
  const Tensor x = difference.slice(1, others) / span.view({1, -1, 1, 1});
  const Tensor balanced = spans[0] / 2 * (x + x.square());
  return others == 0 ? balanced : torch::cat({difference.slice(1, 0, others), balanced}, 1);
}

/// Whether it puts out all maps.
bool is_whole(Task task) {
  return task == Task::kFinetune || task == Task::kJoint;
}

Tensor rendering_loss(const MaterialMaps& estimate, const MaterialMaps& truth, const Tensor& mask,
                      const std::vector<shading::Light<double>>& lights, const LossOptions& options) {
  if (mask.device().is_cpu()) return fused_rendering_loss(estimate, truth, mask, lights, options.shading);
  return chunked_rendering_loss(estimate, truth, mask, lights, options.shading);
}

}  // namespace

const char* name_of(Task task) {
  switch (task) {
    case Task::kGeometry:
      return "geometry";
    case Task::kAlbedo:
      return "albedo";
    case Task::kRss:
      return "rss";
    case Task::kJoint:
      return "joint";
    case Task::kFinetune:
      break;
  }
  return "finetune";
}

Task task_from_name(const std::string& name) {
  for (const Task task : kTasks)
    if (name == name_of(task)) return task;
  throw InputError("", "'" + name + "'", "is no model", "name geometry, albedo, rss, finetune or joint");
}

torch::nn::Module& Network::module() const {
  if (joint) return *joint.ptr();
  if (finetune) return *finetune.ptr();
  return *prior.ptr();
}

Tensor Network::forward(const Tensor& input, const Tensor& guidance) const {
  if (joint) return joint.ptr()->forward(input, guidance);
  if (finetune) return finetune.ptr()->forward(input, guidance);
  return prior.ptr()->forward(input);
}

Tensor mirrored_output(Task task, const Tensor& output) {
  Tensor mirrored = output.flip(3);
  if (task == Task::kGeometry || is_whole(task)) {
    Tensor x = mirrored.select(1, 0);
    x.copy_(1 - x);
  }
  return mirrored;
}

Tensor two_sided_output(Task task, const std::function<Tensor(const Tensor&)>& network, const Tensor& input) {
  const Tensor other = network(input.flip(3));
  return (network(input) + mirrored_output(task, other)) / 2;
}

Network make_network(Task task, double width, bool residual) {
  Network network{task, width, task == Task::kFinetune && residual};
  if (task == Task::kJoint || network.residual)
    network.joint = JointNet(output_channels(task), width, network.residual);
  else if (task == Task::kFinetune)
    network.finetune = FinetuneNet(width);
  else
    network.prior = PriorNet(output_channels(task), width);
  return network;
}

int64_t multiplies_of(const Network& network, int64_t size_px) {
  return multiplies_at(
      [&](int64_t side_px) {
        network.forward(torch::zeros({1, 4, side_px, side_px}),
                        torch::zeros({1, output_channels(Task::kFinetune), side_px, side_px}));
      },
      size_px);
}

int64_t output_channels(Task task) {
  switch (task) {
    case Task::kGeometry:
      return 4;
    case Task::kAlbedo:
      return 3;
    case Task::kRss:
      return rss_channels();
    case Task::kFinetune:
    case Task::kJoint:
      break;
  }
  return 7 + rss_channels();
}

Tensor encoded_maps(Task task, const MaterialMaps& maps) {
  switch (task) {
    case Task::kGeometry:
      return encoded_geometry(maps);
    case Task::kAlbedo:
      return srgb_of(maps.diffuse);
    case Task::kRss:
      return encoded_rss(maps);
    case Task::kFinetune:
    case Task::kJoint:
      break;
  }
  return torch::cat({encoded_geometry(maps), srgb_of(maps.diffuse), encoded_rss(maps)}, 1);
}

MaterialMaps maps_of(Task task, const Tensor& output, MaterialMaps maps) {
  if (task == Task::kGeometry || is_whole(task)) set_geometry(maps, output, 0);
  if (task == Task::kAlbedo) maps.diffuse = linear_of(output);
  if (is_whole(task)) maps.diffuse = linear_of(output.slice(1, 4, 7));
  if (task == Task::kRss) set_rss(maps, output, 0);
  if (is_whole(task)) set_rss(maps, output, 7);
  return maps;
}

Tensor stored_values(const LearnedMap& map, const MaterialMaps& maps) {
  const Tensor& values = maps.*map.tensor;
  if (map.encoding == "offset") return 0.5 + values / 2;
  return map.encoding == "srgb" ? srgb_of(values) : values;
}

MaterialMaps controlled(Task task, MaterialMaps maps, double geometry_roughness) {
  const auto hold = [&](double roughness, double specular) {
    maps.roughness = torch::full_like(maps.roughness, roughness);
    maps.specular = torch::full_like(maps.specular, specular);
  };
  if (task == Task::kGeometry) hold(geometry_roughness, kGeometrySpecular);
  if (task == Task::kAlbedo) hold(kAlbedoRoughness, kAlbedoSpecular);
  return maps;
}

Tensor linear_of(const Tensor& srgb) {
  return torch::where(srgb <= 0.04045, srgb / 12.92,
                      torch::pow((srgb.clamp_min(0.04045) + 0.055) / 1.055, 2.4));
}

Tensor srgb_of(const Tensor& linear) {
  const Tensor x = linear.clamp(0, 1);
  return torch::where(x <= 0.0031308, x * 12.92, 1.055 * torch::pow(x.clamp_min(0.0031308), 1 / 2.4) - 0.055);
}

namespace {

Losses joint_losses_of(const Tensor& output, const MaterialMaps& truth, const Tensor& mask,
                       const std::vector<shading::Light<double>>& lights, const LossOptions& options) {
  Losses joint;
  int64_t first = 0;
  for (const Task task : kPriorTasks) {
    const int64_t end = first + output_channels(task);
    const Losses part = losses_of(task, output.slice(1, first, end), truth, mask, lights, options);
    joint.map = joint.map.defined() ? joint.map + part.map / 3 : part.map / 3;
    joint.render = joint.render.defined() ? joint.render + part.render / 3 : part.render / 3;
    first = end;
  }
  joint.total = joint.map + options.render_weight * joint.render;
  return joint;
}

}  // namespace

Losses losses_of(Task task, const Tensor& output, const MaterialMaps& truth, const Tensor& mask,
                 const std::vector<shading::Light<double>>& lights, const LossOptions& options) {
  if (task == Task::kJoint) return joint_losses_of(output, truth, mask, lights, options);
  const MaterialMaps estimate = maps_of(task, output, truth);
  // Normals count after normalisation: their length in the output means nothing.
  const bool has_normal = task == Task::kGeometry || task == Task::kFinetune;
  const Tensor counted = has_normal ? torch::cat({(estimate.normal + 1) / 2, output.slice(1, 3)}, 1) : output;
  Tensor difference = (counted - encoded_maps(task, truth)).abs();
  const bool has_rss = task == Task::kRss || task == Task::kFinetune;
  if (options.balanced && has_rss) difference = with_balanced_rss(difference);
  difference = difference * mask;
  Losses losses;
  losses.map = difference.sum() / (mask.sum() * static_cast<double>(output.size(1))).clamp_min(1e-6);
  const auto held = [&](const MaterialMaps& maps) {
    return controlled(task, maps, options.control_roughness);
  };
  losses.render = options.render_weight > 0
                      ? rendering_loss(held(estimate), held(truth), mask, lights, options)
                      : torch::zeros({}, output.options());
  losses.total = losses.map + options.render_weight * losses.render;
  return losses;
}

}  // namespace ohb::learner
