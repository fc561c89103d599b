#include "learner/fused_loss.h"

#include <ATen/Parallel.h>
#include <ATen/record_function.h>

#include <cmath>
#include <stdexcept>

#include "learner/hash.h"
#include "learner/shaded_maps.h"

namespace ohb::learner {
namespace {

using torch::Tensor;

constexpr double kLightDistance = 2, kFixedIntensity = 5.5, kMinIntensity = 3, kMaxIntensity = 8;
using shading::kPlaneCount;

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
shading::Planes<Pointer> planes_of(const ShadedMaps& maps, int64_t image) {
  shading::Planes<Pointer> planes{};
  for (size_t i = 0; i < kPlaneCount; ++i)
    if (maps[i].defined())
      planes[i] =
          maps[i].template data_ptr<T>() + image * maps[i].size(1) * maps[i].size(2) * maps[i].size(3);
  return planes;
}

/// The job's arguments that are no tensors.
struct Setting {
  std::vector<shading::Light<double>> lights;
  shading::Options options;
};

template <typename T>
double run(const ShadedMaps& prediction, const ShadedMaps& truth, const ShadedMaps& gradient,
           const Tensor& mask, const Setting& setting) {
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
  check_shaded_maps(prediction, truth, mask);
  if (!mask.device().is_cpu()) throw std::invalid_argument("maps are not on the CPU");
  RECORD_USER_SCOPE("rendering loss");
  const ShadedMaps maps = shaded_maps_of(prediction);
  // The gradients are made too (they cost little more now); the backward pass scales them.
  ShadedMaps estimate, wanted = shaded_maps_of(truth), gradients;
  double loss = 0;
  {
    const torch::NoGradGuard no_gradients;
    for (size_t i = 0; i < kPlaneCount; ++i) {
      if (maps[i].requires_grad()) gradients[i] = torch::zeros_like(maps[i], torch::MemoryFormat::Contiguous);
      estimate[i] = maps[i].contiguous();
      wanted[i] = wanted[i].contiguous();
    }
    const Setting setting{lights, options};
    loss = maps[0].scalar_type() == torch::kDouble ? run<double>(estimate, wanted, gradients, mask, setting)
                                                   : run<float>(estimate, wanted, gradients, mask, setting);
  }
  return with_gradients(torch::full({}, loss, maps[0].options()), maps, gradients);
}

}  // namespace ohb::learner
