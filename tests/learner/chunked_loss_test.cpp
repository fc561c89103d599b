// The rendering loss by chunks of pixels against its two twins, and what it takes of memory.
#include "learner/chunked_loss.h"

#include <ATen/record_function.h>
#include <malloc.h>

#include <algorithm>

#include "test_losses.h"

namespace ohb {
using namespace learner;
namespace {

using torch::Tensor;

constexpr int64_t kLights = 37;

/// Bytes that hold about so many pixels.
constexpr int64_t bytes_of(int64_t pixels, torch::Dtype type) {
  return pixels * kLights * kNumbersPerLitPixel * (type == torch::kDouble ? 8 : 4);
}

Loss chunks_of(int64_t chunk_bytes) {
  return [chunk_bytes](const MaterialMaps& prediction, const MaterialMaps& truth, const Tensor& mask,
                       const std::vector<shading::Light<double>>& lights, const shading::Options& options) {
    return chunked_rendering_loss(prediction, truth, mask, lights, options, chunk_bytes);
  };
}

TEST(ChunkedLoss, EqualsTheFusedLossAndAutogradInDouble) {
  const MaterialMaps truth = random_maps(2, 16, 16, torch::kDouble, 1);
  const MaterialMaps prediction = random_maps(2, 16, 16, torch::kDouble, 2);
  const Tensor mask = half_mask(2, 16, torch::kDouble);
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const Values chunked =
        values_of(chunks_of(bytes_of(100, torch::kDouble)), prediction, truth, mask, c.options);
    expect_equal(chunked, values_of(oracle_rendering_loss, prediction, truth, mask, c.options), 1e-12, 1e-9);
    expect_equal(chunked, values_of(fused_rendering_loss, prediction, truth, mask, c.options), 1e-12, 1e-9);
  }
}

TEST(ChunkedLoss, EqualsTheFusedLossInFloat) {
  const MaterialMaps truth = random_maps(2, 32, 32, torch::kFloat, 3);
  const MaterialMaps prediction = random_maps(2, 32, 32, torch::kFloat, 4);
  const Tensor mask = half_mask(2, 32, torch::kFloat);
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    expect_equal(values_of(chunks_of(kChunkBytes), prediction, truth, mask, c.options),
                 values_of(fused_rendering_loss, prediction, truth, mask, c.options), 1e-5, 1e-3);
  }
}

TEST(ChunkedLoss, DoesNotDependOnTheSizeOfChunks) {
  const MaterialMaps truth = random_maps(2, 16, 16, torch::kDouble, 5);
  const MaterialMaps prediction = random_maps(2, 16, 16, torch::kDouble, 6);
  const Tensor mask = half_mask(2, 16, torch::kDouble);
  const Values whole = values_of(chunks_of(kChunkBytes), prediction, truth, mask, {});
  for (const int64_t bytes : {int64_t{1}, bytes_of(7, torch::kDouble), bytes_of(176, torch::kDouble)})
    expect_equal(values_of(chunks_of(bytes), prediction, truth, mask, {}), whole, 1e-13, 1e-12);
}

// Memory that the process has taken, looked at after every operator.
int64_t g_peak_bytes = 0;

int64_t bytes_in_use() {
  const struct mallinfo2 info = ::mallinfo2();
  return static_cast<int64_t>(info.uordblks + info.hblkhd);
}

void note_peak(const at::RecordFunction&, at::ObserverContext*) {
  g_peak_bytes = std::max(g_peak_bytes, bytes_in_use());
}

/// What the loss and its gradients take at most beyond what was there before.
int64_t peak_bytes_of(const Loss& loss, int64_t batch, int64_t size) {
  MaterialMaps prediction = random_maps(batch, size, size, torch::kFloat, 7);
  const MaterialMaps truth = random_maps(batch, size, size, torch::kFloat, 8);
  const Tensor mask = torch::ones({batch, 1, size, size});
  require_gradients(prediction);
  const int64_t before = g_peak_bytes = bytes_in_use();
  const auto handle = at::addThreadLocalCallback(at::RecordFunctionCallback(nullptr, note_peak));
  loss(prediction, truth, mask, training_lights(7), {}).backward();
  at::removeCallback(handle);
  return g_peak_bytes - before;
}

/// Gradients and indices of the foreground, which are as large as the maps themselves.
int64_t bytes_of_pictures(int64_t batch, int64_t size) {
  return batch * size * size * (10 * 4 + 24 + 2);
}

TEST(ChunkedLoss, TakesTheMemoryOfItsChunksWhateverThePicture) {
  constexpr int64_t kBytes = 8 << 20;
  for (const auto& [batch, size] : {std::pair<int64_t, int64_t>{1, 32}, {1, 64}, {3, 64}}) {
    const int64_t between = peak_bytes_of(chunks_of(kBytes), batch, size) - bytes_of_pictures(batch, size);
    EXPECT_LT(between, kBytes) << batch << " of " << size;
    EXPECT_GT(between, kBytes / 2) << "the memory is used, and the arithmetic holds";
  }
  EXPECT_GT(peak_bytes_of(oracle_rendering_loss, 3, 64), 20 * kBytes) << "so much it is without chunks";
}

TEST(ChunkedLoss, IsZeroWithoutForegroundAndWithoutLights) {
  const MaterialMaps truth = random_maps(1, 16, 16, torch::kFloat, 9);
  MaterialMaps prediction = random_maps(1, 16, 16, torch::kFloat, 10);
  const Values values =
      values_of(chunks_of(kChunkBytes), prediction, truth, torch::zeros({1, 1, 16, 16}), {});
  EXPECT_EQ(values.loss, 0);
  for (const Tensor& gradient : values.gradients) EXPECT_EQ(gradient.abs().max().item<float>(), 0);
  EXPECT_EQ(chunked_rendering_loss(prediction, truth, torch::ones({1, 1, 16, 16}), {}).item<float>(), 0);
}

TEST(ChunkedLoss, FindsOnePixelWhereItIs) {
  const MaterialMaps truth = random_maps(2, 16, 32, torch::kDouble, 11);
  const MaterialMaps prediction = random_maps(2, 16, 32, torch::kDouble, 12);
  Tensor mask = torch::zeros({2, 1, 16, 32}, torch::kDouble);
  mask[1][0][5][27] = 1;
  const Values chunked = values_of(chunks_of(kChunkBytes), prediction, truth, mask, {});
  expect_equal(chunked, values_of(fused_rendering_loss, prediction, truth, mask, {}), 1e-12, 1e-9);
  for (const Tensor& gradient : chunked.gradients)
    EXPECT_EQ((gradient.abs().sum(1) > 0).sum().item<int64_t>(), 1);
}

TEST(ChunkedLoss, GivesGradientsToThoseWhoAskForThem) {
  const MaterialMaps truth = random_maps(1, 16, 16, torch::kDouble, 13);
  MaterialMaps all = random_maps(1, 16, 16, torch::kDouble, 14), some = all;
  const Tensor mask = half_mask(1, 16, torch::kDouble);
  require_gradients(all);
  some.roughness = some.roughness.clone().requires_grad_(true);
  // As a network's output comes: a part of a larger tensor, channels last.
  const Tensor output = all.normal.detach().contiguous(torch::MemoryFormat::ChannelsLast);
  output.requires_grad_(true);
  some.normal = torch::cat({output, output}, 1).slice(1, 3, 6);
  for (MaterialMaps* maps : {&all, &some})
    (2 * chunked_rendering_loss(*maps, truth, mask, training_lights(1))).backward();
  EXPECT_LT(relative_error(some.roughness.grad(), all.roughness.grad()), 1e-12);
  EXPECT_LT(relative_error(output.grad(), all.normal.grad()), 1e-12);
  EXPECT_FALSE(some.diffuse.grad().defined());
  EXPECT_FALSE(chunked_rendering_loss(truth, truth, mask, training_lights(1)).requires_grad());
  const Tensor once = chunked_rendering_loss(all, truth, mask, training_lights(1));
  once.backward({}, true);
  EXPECT_THROW(once.backward(), std::logic_error);
}

TEST(ChunkedLoss, ShowsNaNOfTheForegroundOnly) {
  const MaterialMaps truth = random_maps(1, 16, 16, torch::kFloat, 15);
  const Tensor mask = half_mask(1, 16, torch::kFloat);  // up to column 10
  for (const int64_t column : {10, 11})
    for (size_t map = 0; map < 6; ++map) {
      MaterialMaps prediction = random_maps(1, 16, 16, torch::kFloat, 16);
      tensors_of(prediction)[map]->slice(3, column, column + 1).fill_(std::nanf(""));
      const double loss = chunked_rendering_loss(prediction, truth, mask, training_lights(7)).item<double>();
      EXPECT_EQ(std::isnan(loss), column == 10) << kMapNames[map] << " " << column;
    }
}

TEST(ChunkedLoss, RefusesWhatDoesNotFitTogether) {
  const MaterialMaps maps = random_maps(1, 16, 16, torch::kFloat, 17);
  const auto lights = training_lights(0);
  EXPECT_THROW(chunked_rendering_loss(maps, maps, torch::ones({1, 1, 8, 16}), lights), std::invalid_argument);
  EXPECT_THROW(chunked_rendering_loss(maps, random_maps(1, 16, 16, torch::kDouble, 1),
                                      torch::ones({1, 1, 16, 16}), lights),
               std::invalid_argument);
  MaterialMaps elsewhere = maps;
  elsewhere.sss = elsewhere.sss.to(torch::kMeta);
  EXPECT_THROW(chunked_rendering_loss(elsewhere, maps, torch::ones({1, 1, 16, 16}), lights),
               std::invalid_argument);
}

}  // namespace
}  // namespace ohb
