#include "learner/fused_loss.h"

#include <ATen/Parallel.h>
#include <ATen/record_function.h>

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "learner/hash.h"

namespace ohb::learner {
namespace {

using torch::Tensor;
using torch::autograd::AutogradContext;
using torch::autograd::Variable;
using torch::autograd::variable_list;

constexpr double kLightDistance = 2, kFixedIntensity = 5.5, kMinIntensity = 3, kMaxIntensity = 8;
using shading::kPlaneCount;

/// What the learner calls the maps that the shader reads.
constexpr std::array<const LearnedMap*, kPlaneCount> shaded_maps() {
  std::array<const LearnedMap*, kPlaneCount> maps{};
  for (size_t i = 0; i < kPlaneCount; ++i)
    for (const LearnedMap& map : kMaps)
      if (map.name == shading::kPlaneNames[i]) maps[i] = &map;
  return maps;
}
constexpr std::array<const LearnedMap*, kPlaneCount> kShadedMaps = shaded_maps();

/// By shading::Plane.
using Tensors = std::array<Tensor, kPlaneCount>;

Tensors tensors_of(const MaterialMaps& maps) {
  Tensors tensors;
  for (size_t i = 0; i < kPlaneCount; ++i) tensors[i] = maps.*kShadedMaps[i]->tensor;
  return tensors;
}

void check(const MaterialMaps& maps, const Tensor& mask, const char* whose) {
  if (mask.dim() != 4 || mask.size(1) != 1) throw std::invalid_argument("mask is not (B, 1, H, W)");
  for (const LearnedMap* shaded : kShadedMaps) {
    const Tensor& map = maps.*shaded->tensor;
    if (!map.defined() || map.dim() != 4 || map.size(0) != mask.size(0) ||
        map.size(1) != static_cast<int64_t>(shaded->channels.size()) || map.size(2) != mask.size(2) ||
        map.size(3) != mask.size(3))
      throw std::invalid_argument(std::string(shaded->name) + " of the " + whose +
                                  " has another shape than (B, C, H, W) of the mask");
    if (map.scalar_type() != maps.normal.scalar_type() || !map.device().is_cpu())
      throw std::invalid_argument(std::string("maps of the ") + whose +
                                  " differ in type or are not on the CPU");
  }
}

/// Indices y * width + x of the foreground of one image.
std::vector<int32_t> foreground_of(const Tensor& mask) {
  const Tensor values = mask.to(torch::kFloat).contiguous();
  const float* data = values.data_ptr<float>();
  std::vector<int32_t> pixels;
  for (int64_t i = 0; i < values.numel(); ++i)
    if (data[i] > 0.5f) pixels.push_back(static_cast<int32_t>(i));
  return pixels;
}

template <typename T, typename Pointer>
shading::Planes<Pointer> planes_of(const Tensors& tensors, int64_t image) {
  shading::Planes<Pointer> planes{};
  for (size_t i = 0; i < kPlaneCount; ++i)
    if (tensors[i].defined())
      planes[i] = tensors[i].template data_ptr<T>() +
                  image * tensors[i].size(1) * tensors[i].size(2) * tensors[i].size(3);
  return planes;
}

/// The job's arguments that are no tensors.
struct Setting {
  std::vector<shading::Light<double>> lights;
  shading::Options options;
};

template <typename T>
double run(const Tensors& prediction, const Tensors& truth, const Tensors& gradient, const Tensor& mask,
           const Setting& setting) {
  std::vector<std::vector<int32_t>> pixels;
  size_t count = 0;
  for (int64_t b = 0; b < mask.size(0); ++b) {
    pixels.push_back(foreground_of(mask[b]));
    count += pixels.back().size();
  }
  if (count == 0 || setting.lights.empty()) return 0;
  shading::Job<T> job;
  job.height_px = static_cast<int>(mask.size(2));
  job.width_px = static_cast<int>(mask.size(3));
  job.options = setting.options;
  job.scale = 1 / (3.0 * static_cast<double>(count) * static_cast<double>(setting.lights.size()));
  for (const auto& light : setting.lights)
    job.lights.push_back({static_cast<T>(light.x), static_cast<T>(light.y), static_cast<T>(light.z),
                          static_cast<T>(light.intensity)});
  double loss = 0;
  for (int64_t b = 0; b < mask.size(0); ++b) {
    job.prediction = planes_of<T, const T*>(prediction, b);
    job.truth = planes_of<T, const T*>(truth, b);
    job.gradient = planes_of<T, T*>(gradient, b);
    loss += shading::loss_of_pixels(job, pixels[b], at::get_num_threads());
  }
  return loss;
}

/// The forward pass makes the gradients too (they cost little more then); backward scales them.
class FusedLoss : public torch::autograd::Function<FusedLoss> {
 public:
  static Tensor forward(AutogradContext* context, at::TensorList maps, const MaterialMaps& truth,
                        const Tensor& mask, const Setting& setting) {
    Tensors prediction, wanted = tensors_of(truth), gradient;
    std::copy(maps.begin(), maps.end(), prediction.begin());
    for (size_t i = 0; i < kPlaneCount; ++i) {
      if (prediction[i].requires_grad())
        gradient[i] = torch::zeros_like(prediction[i], torch::MemoryFormat::Contiguous);
      prediction[i] = prediction[i].contiguous();
      wanted[i] = wanted[i].contiguous();
    }
    const double loss = maps[0].scalar_type() == torch::kDouble
                            ? run<double>(prediction, wanted, gradient, mask, setting)
                            : run<float>(prediction, wanted, gradient, mask, setting);
    for (size_t i = 0; i < kPlaneCount; ++i) context->saved_data[std::to_string(i)] = gradient[i];
    return torch::full({}, loss, maps[0].options().requires_grad(false));
  }

  static variable_list backward(AutogradContext* context, variable_list outer) {
    // Handed over, not copied: a second copy of the planes would double the memory.
    auto& saved = context->saved_data;
    if (saved.empty()) throw std::logic_error("fused_rendering_loss: backward may run once");
    variable_list gradients;
    for (size_t i = 0; i < kPlaneCount; ++i) {
      Tensor gradient = saved.at(std::to_string(i)).toTensor();
      saved.erase(std::to_string(i));
      gradients.push_back(gradient.defined() ? gradient.mul_(outer[0]) : Tensor());
    }
    gradients.resize(kPlaneCount + 3);  // truth, mask and setting get none
    return gradients;
  }
};

}  // namespace

std::vector<shading::Light<double>> training_lights(uint64_t random_key) {
  std::vector<shading::Light<double>> lights;
  for (int degrees = 5; degrees < 180; degrees += 10) {
    const double along = kLightDistance * std::cos(degrees * shading::kPi / 180);
    const double towards = kLightDistance * std::sin(degrees * shading::kPi / 180);
    lights.push_back({along, 0, towards, kFixedIntensity});
    lights.push_back({0, along, towards, kFixedIntensity});
  }
  // Uniform on the hemisphere: the height is uniform.
  const double z = uniform_of(random_key, 0), turn = 2 * shading::kPi * uniform_of(random_key, 1);
  const double across = std::sqrt(1 - z * z);
  lights.push_back({kLightDistance * across * std::cos(turn), kLightDistance * across * std::sin(turn),
                    kLightDistance * z,
                    kMinIntensity + (kMaxIntensity - kMinIntensity) * uniform_of(random_key, 2)});
  return lights;
}

shading::Light<double> evaluation_light() {
  return {0, 0, kLightDistance, kFixedIntensity};
}

Tensor fused_rendering_loss(const MaterialMaps& prediction, const MaterialMaps& truth, const Tensor& mask,
                            const std::vector<shading::Light<double>>& lights,
                            const shading::Options& options) {
  check(prediction, mask, "prediction");
  check(truth, mask, "truth");
  if (truth.normal.scalar_type() != prediction.normal.scalar_type())
    throw std::invalid_argument("truth and prediction differ in type");
  const Tensors maps = tensors_of(prediction);
  RECORD_USER_SCOPE("rendering loss");
  return FusedLoss::apply(at::TensorList(maps), truth, mask, Setting{lights, options});
}

}  // namespace ohb::learner
