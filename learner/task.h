// The five things that can be trained, their networks behind one face, and how outputs and maps correspond.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "learner/fused_loss.h"
#include "learner/networks.h"

namespace ohb::learner {

enum class Task { kGeometry, kAlbedo, kRss, kFinetune, kJoint };
constexpr std::array<Task, 5> kTasks = {Task::kGeometry, Task::kAlbedo, Task::kRss, Task::kFinetune,
                                        Task::kJoint};
/// Together they put out what kFinetune and kJoint do, in this order.
constexpr std::array<Task, 3> kPriorTasks = {Task::kGeometry, Task::kAlbedo, Task::kRss};

/// "geometry", "albedo", "rss", "finetune", "joint".
const char* name_of(Task task);
/// Throws InputError for another name.
Task task_from_name(const std::string& name);

/// A network of any of the tasks.
struct Network {
  Task task;
  double width;
  bool residual;                  // finetune: a joint network that refines, not the paper's network
  PriorNet prior{nullptr};        // geometry, albedo, rss
  FinetuneNet finetune{nullptr};  // finetune
  JointNet joint{nullptr};        // joint, residual finetune

  torch::nn::Module& module() const;
  /// `guidance` (B, 10, H, W) is used by finetune only. Output: (B, output_channels(task), H, W) in (0, 1).
  torch::Tensor forward(const torch::Tensor& input, const torch::Tensor& guidance) const;
};

/// Freshly initialised; torch::manual_seed decides with what.
Network make_network(Task task, double width, bool residual = false);

/// Multiply-accumulates of one picture of size_px x size_px, as multiplies_at counts them.
int64_t multiplies_of(const Network& network, int64_t size_px);

/// The mean of a network's output and of the output for the mirrored picture, mirrored back: the maps of a
/// mirror image are the mirror image of the maps, so that where the two differ both err. Twice the time.
torch::Tensor two_sided_output(Task task, const std::function<torch::Tensor(const torch::Tensor&)>& network,
                               const torch::Tensor& input);

/// Exchanges left and right of a network's output (B, C, H, W), or of guidance: x components of normals,
/// encoded as (x + 1) / 2, change their sign.
torch::Tensor mirrored_output(Task task, const torch::Tensor& output);

/// geometry 4: normal as (n + 1) / 2, displacement as 0.5 + d / 2 (d in half frames). albedo 3: sRGB-encoded.
/// rss 3: those of kMaps with a span (roughness, S, sss). finetune and joint 10: normal, displacement,
/// albedo, rss.
int64_t output_channels(Task task);

/// The maps as a network of that task puts them out; the inverse of maps_of.
torch::Tensor encoded_maps(Task task, const MaterialMaps& maps);

/// `maps` with those of the task replaced by its output (normals of unit length, albedo linear).
MaterialMaps maps_of(Task task, const torch::Tensor& output, MaterialMaps maps);

/// A map of `maps` as its PNG holds it, in [0, 1]: LearnedMap::encoding.
torch::Tensor stored_values(const LearnedMap& map, const MaterialMaps& maps);

constexpr double kGeometryRoughness = 0.2;  // the paper's

/// Controlled PBR rendering (CPR): the materials that a prior does not estimate are held, in truth and
/// prediction alike, at values that make its own matter most. geometry: `geometry_roughness`, S 0.5; albedo:
/// roughness 0.8, S 0.03; all others as in the truth.
MaterialMaps controlled(Task task, MaterialMaps maps, double geometry_roughness = kGeometryRoughness);

/// Encoded sRGB to linear, for values in [0, 1].
torch::Tensor linear_of(const torch::Tensor& srgb);
torch::Tensor srgb_of(const torch::Tensor& linear);

struct Losses {
  torch::Tensor total, map, render;
};

struct LossOptions {
  double render_weight = 1;
  shading::Options shading = {};
  bool balanced = false;                          // roughness, specular and sss count alike
  double control_roughness = kGeometryRoughness;  // of CPR, geometry and joint
};

/// map: L1 of encoded outputs and truth (normals normalised first), averaged over channels and, by coverage,
/// over the foreground. render: fused_rendering_loss under CPR (on other devices than the CPU
/// chunked_rendering_loss, the same), 0 for no weight. total = map + render_weight x render.
///
/// `balanced` (not in the paper) counts roughness, S and sss in units of the span that each has in the table
/// of materials (0.6, 0.079, 0.08), and takes the mean of the absolute and the squared difference. S and sss
/// then weigh as much as roughness does; and where the material is uncertain the squared part asks for its
/// mean, which is what PSNR judges, not for the likelier of two.
///
/// joint: the means of the three priors' losses of its parts, each under its own CPR.
Losses losses_of(Task task, const torch::Tensor& output, const MaterialMaps& truth, const torch::Tensor& mask,
                 const std::vector<shading::Light<double>>& lights, const LossOptions& options = {});

}  // namespace ohb::learner
