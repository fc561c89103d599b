// The fused rendering loss against its plain twin, against finite differences, and where it could fail.
#include "learner/fused_loss.h"

#include <gtest/gtest.h>

#include "test_losses.h"

namespace ohb {
using namespace learner;
namespace {

using torch::Tensor;

TEST(TrainingLights, AreThirtySevenOnTheViewersSide) {
  for (const uint64_t key : {0ull, 1ull, 99ull}) {
    const auto lights = training_lights(key);
    ASSERT_EQ(lights.size(), 37u);
    for (const auto& light : lights) {
      EXPECT_GT(light.z, 0);
      EXPECT_NEAR(std::sqrt(light.x * light.x + light.y * light.y + light.z * light.z), 2, 1e-12);
    }
    EXPECT_GE(lights.back().intensity, 3);
    EXPECT_LE(lights.back().intensity, 8);
  }
  EXPECT_EQ(training_lights(5).back().x, training_lights(5).back().x);
  EXPECT_NE(training_lights(5).back().x, training_lights(6).back().x);
}

TEST(Shader, HasTheValueOfAHandComputation) {
  // A patch that faces viewer and light: NL = NV = NH = LH = 1, so that Fd = 1, D G F = F0 / (4 pi a^2).
  shading::Surface<double> s{0, 0, 0, 0, 0, 1, 0.5, 0.25, 0, 0.5, 0.04, 0};
  const auto r = shading::reflect(s, evaluation_light());
  const double specular = 0.04 / (4 * shading::kPi * 0.0625), irradiance = 5.5 / 4;
  EXPECT_NEAR(r.out0, (0.5 / shading::kPi + specular) * irradiance, 1e-12);
  EXPECT_NEAR(r.out2, specular * irradiance, 1e-12);
  s.sss = 1;  // Fss = r, so ss = 1.25 (r^2 ... at w = 0: 1 (1/2 - 1/2) + 1/2) = 0.625
  EXPECT_NEAR(shading::reflect(s, evaluation_light()).out0,
              (0.625 * 0.5 / shading::kPi + specular) * irradiance, 1e-12);
}

TEST(FusedLoss, EqualsAutogradInFloat) {
  const MaterialMaps truth = random_maps(2, 32, 32, torch::kFloat, 1);
  const MaterialMaps prediction = random_maps(2, 32, 32, torch::kFloat, 2);
  const Tensor mask = half_mask(2, 32, torch::kFloat);
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    expect_equal(values_of(fused_rendering_loss, prediction, truth, mask, c.options),
                 values_of(oracle_rendering_loss, prediction, truth, mask, c.options), 1e-5, 1e-3);
  }
}

TEST(FusedLoss, EqualsAutogradInDouble) {
  const MaterialMaps truth = random_maps(1, 16, 16, torch::kDouble, 3);
  const MaterialMaps prediction = random_maps(1, 16, 16, torch::kDouble, 4);
  const Tensor mask = half_mask(1, 16, torch::kDouble);
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    expect_equal(values_of(fused_rendering_loss, prediction, truth, mask, c.options),
                 values_of(oracle_rendering_loss, prediction, truth, mask, c.options), 1e-12, 1e-6);
  }
}

TEST(FusedLoss, HasTheGradientOfFiniteDifferences) {
  const MaterialMaps truth = random_maps(1, 8, 8, torch::kDouble, 5);
  MaterialMaps prediction = random_maps(1, 8, 8, torch::kDouble, 6);
  prediction.normal = prediction.normal * 1.7;  // any length will do
  const Tensor mask = torch::ones({1, 1, 8, 8}, torch::kDouble);
  const Values analytic = values_of(fused_rendering_loss, prediction, truth, mask, {});
  const auto maps = tensors_of(prediction);
  constexpr double kStep = 1e-6;
  for (size_t m = 0; m < maps.size(); ++m)
    for (int64_t i = 0; i < maps[m]->numel(); i += 7) {
      double* value = maps[m]->data_ptr<double>() + i;
      const double old = *value;
      double at[2];
      for (const int side : {0, 1}) {
        *value = old + (side ? kStep : -kStep);
        at[side] = fused_rendering_loss(prediction, truth, mask, training_lights(7)).item<double>();
      }
      *value = old;
      const double numeric = (at[1] - at[0]) / (2 * kStep);
      const double scale = analytic.gradients[m].abs().max().item<double>();
      EXPECT_NEAR(analytic.gradients[m].view(-1)[i].item<double>(), numeric, 1e-5 * scale)
          << kMapNames[m] << " " << i;
    }
}

TEST(FusedLoss, HasNoGradientAtTheTruthItself) {
  const MaterialMaps truth = random_maps(1, 16, 16, torch::kFloat, 8);
  const Values values = values_of(fused_rendering_loss, truth, truth, torch::ones({1, 1, 16, 16}), {});
  EXPECT_EQ(values.loss, 0);
  for (const Tensor& gradient : values.gradients) EXPECT_EQ(gradient.abs().max().item<float>(), 0);
}

TEST(FusedLoss, DoesNotDependOnTheNumberOfThreads) {
  const MaterialMaps truth = random_maps(1, 64, 64, torch::kFloat, 9);
  const MaterialMaps prediction = random_maps(1, 64, 64, torch::kFloat, 10);
  const Tensor mask = half_mask(1, 64, torch::kFloat);
  const int threads = torch::get_num_threads();
  torch::set_num_threads(1);
  const Values one = values_of(fused_rendering_loss, prediction, truth, mask, {});
  torch::set_num_threads(3);
  const Values three = values_of(fused_rendering_loss, prediction, truth, mask, {});
  torch::set_num_threads(threads);
  EXPECT_EQ(one.loss, three.loss);
  for (size_t i = 0; i < one.gradients.size(); ++i)
    EXPECT_TRUE(one.gradients[i].equal(three.gradients[i])) << kMapNames[i];
}

// Roughness 0.03 where it isn't raised: fp32 against double. The truth faces away and is black, so that no
// difference is near 0, where its sign (and with it the gradient) would hang on the last bit.
TEST(FusedLoss, KeepsItsDigitsAtLowRoughness) {
  for (const auto& [roughness, tolerance] : {std::pair{0.2, 1e-5}, {0.1, 3e-5}, {0.05, 1e-4}, {0.03, 3e-4}}) {
    shading::Options options;
    options.min_roughness = 0.01;
    MaterialMaps truth = random_maps(1, 48, 48, torch::kFloat, 11);
    truth.normal.neg_();
    MaterialMaps prediction = random_maps(1, 48, 48, torch::kFloat, 12);
    prediction.roughness.fill_(roughness);
    const Tensor mask = torch::ones({1, 1, 48, 48}, torch::kDouble);
    const Values in_float = values_of(fused_rendering_loss, prediction, truth, mask, options);
    for (Tensor* map : tensors_of(truth)) *map = map->to(torch::kDouble);
    for (Tensor* map : tensors_of(prediction)) *map = map->to(torch::kDouble);
    const Values in_double = values_of(fused_rendering_loss, prediction, truth, mask, options);
    EXPECT_NEAR(in_float.loss, in_double.loss, 1e-6 * in_double.loss) << roughness;
    for (size_t i = 0; i < in_float.gradients.size(); ++i)
      EXPECT_LT(relative_error(in_float.gradients[i].to(torch::kDouble), in_double.gradients[i]), tolerance)
          << kMapNames[i] << " at roughness " << roughness;
  }
}

TEST(FusedLoss, RaisesRoughnessWithoutGradient) {
  const MaterialMaps truth = random_maps(1, 16, 16, torch::kFloat, 13);
  MaterialMaps prediction = random_maps(1, 16, 16, torch::kFloat, 14);
  prediction.roughness.fill_(0.03f);
  const Tensor mask = torch::ones({1, 1, 16, 16});
  const Values values = values_of(fused_rendering_loss, prediction, truth, mask, {});
  EXPECT_EQ(values.gradients[2].abs().max().item<float>(), 0);
  prediction.roughness.fill_(0.15f);
  EXPECT_FLOAT_EQ(values_of(fused_rendering_loss, prediction, truth, mask, {}).loss, values.loss);
}

TEST(FusedLoss, StaysFiniteAtGrazingBackFacingAndDegenerateNormals) {
  const MaterialMaps truth = random_maps(1, 16, 16, torch::kFloat, 15);
  const Tensor mask = torch::ones({1, 1, 16, 16});
  const std::vector<std::array<float, 3>> normals = {{1, 0, 0},        {1, 0, 1e-4f}, {0, 1, 1.1e-4f},
                                                     {0, 0, -1},       {0, 0, 0},     {1e-6f, 0, 0},
                                                     {.7f, .7f, -.1f}, {0, 0, 1e6f}};
  for (const auto& n : normals) {
    MaterialMaps prediction = random_maps(1, 16, 16, torch::kFloat, 16);
    for (int c = 0; c < 3; ++c) prediction.normal.select(1, c).fill_(n[c]);
    const Values values = values_of(fused_rendering_loss, prediction, truth, mask, {});
    EXPECT_TRUE(std::isfinite(values.loss)) << n[0] << " " << n[1] << " " << n[2];
    for (size_t i = 0; i < values.gradients.size(); ++i)
      EXPECT_TRUE(torch::isfinite(values.gradients[i]).all().item<bool>())
          << kMapNames[i] << " at " << n[0] << " " << n[1] << " " << n[2];
  }
}

TEST(FusedLoss, IsZeroWithoutForeground) {
  const MaterialMaps maps = random_maps(1, 16, 16, torch::kFloat, 17);
  const Values values = values_of(fused_rendering_loss, maps, random_maps(1, 16, 16, torch::kFloat, 18),
                                  torch::zeros({1, 1, 16, 16}), {});
  EXPECT_EQ(values.loss, 0);
  for (const Tensor& gradient : values.gradients) EXPECT_EQ(gradient.abs().max().item<float>(), 0);
}

TEST(FusedLoss, ShowsNaNInsteadOfHidingIt) {
  const MaterialMaps truth = random_maps(1, 16, 16, torch::kFloat, 19);
  for (int map = 0; map < 6; ++map) {
    MaterialMaps prediction = random_maps(1, 16, 16, torch::kFloat, 20);
    tensors_of(prediction)[map]->view(-1)[100].fill_(std::nanf(""));
    const double loss =
        fused_rendering_loss(prediction, truth, torch::ones({1, 1, 16, 16}), training_lights(7))
            .item<double>();
    EXPECT_TRUE(std::isnan(loss)) << kMapNames[map];
  }
}

TEST(FusedLoss, IgnoresWhatTheBackgroundHolds) {
  const MaterialMaps truth = random_maps(1, 16, 16, torch::kFloat, 21);
  MaterialMaps prediction = random_maps(1, 16, 16, torch::kFloat, 22);
  const Tensor mask = half_mask(1, 16, torch::kFloat);
  const Values clean = values_of(fused_rendering_loss, prediction, truth, mask, {});
  for (Tensor* map : tensors_of(prediction)) map->slice(3, 12, 16).fill_(std::nanf(""));
  const Values dirty = values_of(fused_rendering_loss, prediction, truth, mask, {});
  EXPECT_EQ(clean.loss, dirty.loss);
  for (size_t i = 0; i < clean.gradients.size(); ++i)
    EXPECT_TRUE(clean.gradients[i].equal(dirty.gradients[i]));
}

TEST(FusedLoss, RefusesShapesThatDoNotFit) {
  const MaterialMaps maps = random_maps(1, 16, 16, torch::kFloat, 23);
  EXPECT_THROW(fused_rendering_loss(maps, maps, torch::ones({1, 1, 8, 16}), training_lights(0)),
               std::invalid_argument);
  MaterialMaps wrong = maps;
  wrong.roughness = torch::ones({1, 3, 16, 16});
  EXPECT_THROW(fused_rendering_loss(wrong, maps, torch::ones({1, 1, 16, 16}), training_lights(0)),
               std::invalid_argument);
  EXPECT_THROW(fused_rendering_loss(maps, random_maps(1, 16, 16, torch::kDouble, 1),
                                    torch::ones({1, 1, 16, 16}), training_lights(0)),
               std::invalid_argument);
}

}  // namespace
}  // namespace ohb
