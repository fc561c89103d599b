#include "learner/chunked_loss.h"

#include <ATen/record_function.h>

#include <algorithm>

#include "learner/oracle.h"
#include "learner/shaded_maps.h"

namespace ohb::learner {
namespace {

using torch::Tensor;
using torch::indexing::TensorIndex;

/// Where pixels are in the batch: indices, each (N).
struct Pixels {
  Tensor image, row, column;

  std::vector<TensorIndex> index() const { return {image, row, column}; }
};

/// (B, C, H, W) by pixel and channel.
Tensor by_pixel(const Tensor& map) {
  return map.permute({0, 2, 3, 1});
}

/// The maps' values at these pixels: (1, C, 1, N).
MaterialMaps gathered(const ShadedMaps& maps, const Pixels& pixels) {
  MaterialMaps values;
  for (size_t i = 0; i < maps.size(); ++i)
    values.*kShadedMaps[i]->tensor =
        by_pixel(maps[i]).index(pixels.index()).t().contiguous().unsqueeze(1).unsqueeze(0);
  return values;
}

/// Those of `maps` that need gradients, as leaves of their own.
std::vector<Tensor> leaves_of(MaterialMaps& maps, const ShadedMaps& gradients) {
  std::vector<Tensor> leaves;
  for (size_t i = 0; i < gradients.size(); ++i)
    if (gradients[i].defined()) leaves.push_back((maps.*kShadedMaps[i]->tensor).requires_grad_(true));
  return leaves;
}

void scatter(const std::vector<Tensor>& values, const Pixels& pixels, const ShadedMaps& gradients) {
  size_t next = 0;
  for (const Tensor& gradient : gradients)
    if (gradient.defined())
      by_pixel(gradient).index_put_(pixels.index(), values[next++].squeeze(0).squeeze(1).t());
}

/// What is the same for all chunks.
struct Job {
  ShadedMaps prediction, truth, gradients;
  std::vector<shading::Light<double>> lights;
  shading::Options options;
  double scale;
};

/// The chunk's part of the loss, as a double; writes its gradients.
Tensor loss_of_chunk(const Job& job, const Pixels& pixels, const PixelPlaces& places) {
  const Tensor wanted = render_pixels(gathered(job.truth, pixels), places, job.lights, job.options);
  MaterialMaps estimate = gathered(job.prediction, pixels);
  const std::vector<Tensor> leaves = leaves_of(estimate, job.gradients);
  const torch::AutoGradMode recording(!leaves.empty());
  const Tensor mine = render_pixels(estimate, places, job.lights, job.options);
  const Tensor loss = radiance_difference(mine, wanted, job.options).sum(torch::kDouble) * job.scale;
  if (!leaves.empty()) {
    const std::vector<Tensor> values = torch::autograd::grad({loss}, leaves);
    const torch::NoGradGuard no_gradients;
    scatter(values, pixels, job.gradients);
  }
  return loss.detach();
}

int64_t pixels_of_chunk(int64_t chunk_bytes, int64_t lights, const Tensor& like) {
  const int64_t bytes_a_pixel = lights * kNumbersPerLitPixel * static_cast<int64_t>(like.element_size());
  return std::max<int64_t>(1, chunk_bytes / bytes_a_pixel);
}

/// Of all the foreground, as a double.
Tensor loss_by_chunks(Job& job, const Tensor& mask, int64_t chunk_bytes) {
  const Tensor& like = job.prediction[0];
  Tensor loss = torch::zeros({}, like.options().dtype(torch::kDouble));
  const Tensor foreground = (mask.squeeze(1) > 0.5).nonzero();  // image, row and column of each pixel
  const int64_t count = foreground.size(0);
  if (count == 0 || job.lights.empty()) return loss;
  job.scale = 1 / (3.0 * static_cast<double>(count) * static_cast<double>(job.lights.size()));
  const int64_t together = pixels_of_chunk(chunk_bytes, static_cast<int64_t>(job.lights.size()), like);
  for (int64_t begin = 0; begin < count; begin += together) {
    const std::vector<Tensor> at = foreground.slice(0, begin, std::min(count, begin + together)).unbind(1);
    const auto plane = [&](const Tensor& index) { return index.to(like.scalar_type()).view({1, 1, 1, -1}); };
    const PixelPlaces places = places_of(plane(at[2]), plane(at[1]), mask.size(3), mask.size(2));
    loss += loss_of_chunk(job, {at[0], at[1], at[2]}, places);
  }
  return loss;
}

}  // namespace

Tensor chunked_rendering_loss(const MaterialMaps& prediction, const MaterialMaps& truth, const Tensor& mask,
                              const std::vector<shading::Light<double>>& lights,
                              const shading::Options& options, int64_t chunk_bytes) {
  check_shaded_maps(prediction, truth, mask);
  RECORD_USER_SCOPE("rendering loss");
  const ShadedMaps maps = shaded_maps_of(prediction);
  Job job{maps, shaded_maps_of(truth), {}, lights, options, 1};
  Tensor loss;
  {
    const torch::NoGradGuard no_gradients;
    for (size_t i = 0; i < maps.size(); ++i)
      if (maps[i].requires_grad())
        job.gradients[i] = torch::zeros_like(maps[i], torch::MemoryFormat::Contiguous);
    loss = loss_by_chunks(job, mask, chunk_bytes).to(maps[0].scalar_type());
  }
  return with_gradients(loss, maps, job.gradients);
}

}  // namespace ohb::learner
