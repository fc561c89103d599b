// Outputs to maps and back, controlled values, and the losses of a task.
#include "learner/task.h"

#include <gtest/gtest.h>

#include "dataset/model/colour.h"
#include "test_maps.h"

namespace ohb {
using namespace learner;
namespace {

using torch::Tensor;

TEST(Task, EncodingAndDecodingAreInverse) {
  const MaterialMaps maps = random_maps(2, 16, 16, torch::kFloat, 1);
  const MaterialMaps other = random_maps(2, 16, 16, torch::kFloat, 2);
  for (const Task task : kTasks) {
    const Tensor encoded = encoded_maps(task, maps);
    EXPECT_EQ(encoded.size(1), output_channels(task)) << name_of(task);
    EXPECT_TRUE(torch::allclose(encoded_maps(task, maps_of(task, encoded, other)), encoded, 1e-4, 1e-5))
        << name_of(task);
    EXPECT_EQ(task_from_name(name_of(task)), task);
  }
  MaterialMaps all = maps_of(Task::kFinetune, encoded_maps(Task::kFinetune, maps), other);
  MaterialMaps wanted = maps;
  for (size_t i = 0; i < 6; ++i)
    EXPECT_TRUE(torch::allclose(*tensors_of(all)[i], *tensors_of(wanted)[i], 1e-4, 1e-5)) << kMapNames[i];
}

TEST(Task, TransferFunctionsEqualTheDataModels) {
  for (const float v : {0.f, 0.002f, 0.01f, 0.2f, 0.9f, 1.f}) {
    EXPECT_NEAR(linear_of(torch::tensor(v)).item<float>(), srgb_to_linear(v), 1e-6);
    EXPECT_NEAR(srgb_of(torch::tensor(v)).item<float>(), linear_to_srgb(v), 1e-6);
  }
  // At black the gradient is finite.
  Tensor black = torch::zeros({1}).requires_grad_(true);
  linear_of(black).sum().backward();
  EXPECT_NEAR(black.grad().item<float>(), 1 / 12.92, 1e-6);
}

TEST(Task, ControlHoldsWhatAPriorDoesNotEstimate) {
  const MaterialMaps maps = random_maps(1, 8, 8, torch::kFloat, 3);
  const MaterialMaps geometry = controlled(Task::kGeometry, maps), albedo = controlled(Task::kAlbedo, maps);
  EXPECT_FLOAT_EQ(geometry.roughness.max().item<float>(), 0.2f);
  EXPECT_FLOAT_EQ(geometry.specular.min().item<float>(), 0.5f);
  EXPECT_TRUE(geometry.diffuse.equal(maps.diffuse));
  EXPECT_FLOAT_EQ(albedo.roughness.max().item<float>(), 0.8f);
  EXPECT_FLOAT_EQ(albedo.specular.min().item<float>(), 0.03f);
  EXPECT_TRUE(controlled(Task::kRss, maps).roughness.equal(maps.roughness));
  EXPECT_FLOAT_EQ(controlled(Task::kGeometry, maps, 0.6).roughness.min().item<float>(), 0.6f);
}

// The invariant that the mean of both sides exists for: mirrored picture, mirrored maps.
TEST(Task, TwoSidedOutputsAreThoseOfTheMirrorImageMirrored) {
  torch::manual_seed(3);
  const Tensor input = torch::rand({2, 4, 32, 32}) * 2 - 1;
  torch::NoGradGuard no_gradients;
  for (const Task task : kTasks) {
    const Network network = make_network(task, 0.1);
    const auto forward = [&](const Tensor& x) {  // any guidance will do
      return network.forward(x, torch::cat({x, x, x.slice(1, 0, 2)}, 1).sigmoid());
    };
    const Tensor output = two_sided_output(task, forward, input);
    const Tensor mirrored = two_sided_output(task, forward, input.flip(3));
    EXPECT_TRUE(torch::allclose(mirrored, mirrored_output(task, output), 1e-4, 1e-5)) << name_of(task);
    EXPECT_FALSE(torch::allclose(forward(input), output, 1e-3, 1e-3)) << name_of(task);
  }
  // Normals that point to the right point to the left, and stand where the left was.
  MaterialMaps maps;
  maps.normal = torch::zeros({1, 3, 16, 16});
  maps.normal.select(1, 0).slice(2, 0, 8).fill_(1);
  maps.displacement = torch::zeros({1, 1, 16, 16});
  const MaterialMaps turned =
      maps_of(Task::kGeometry, mirrored_output(Task::kGeometry, encoded_maps(Task::kGeometry, maps)), {});
  EXPECT_NEAR(turned.normal[0][0][4][12].item<double>(), -1, 1e-6);
  EXPECT_NEAR(turned.normal[0][0][4][2].item<double>(), 0, 1e-6);
}

TEST(Losses, AreZeroForTheTruthAndFallToIt) {
  const MaterialMaps truth = random_maps(1, 16, 16, torch::kFloat, 4);
  const Tensor mask = torch::ones({1, 1, 16, 16});
  for (const Task task : kTasks) {
    const Tensor exact = encoded_maps(task, truth);
    const Losses zero = losses_of(task, exact, truth, mask, training_lights(1));
    EXPECT_NEAR(zero.total.item<double>(), 0, 1e-4) << name_of(task);
    Tensor near = (exact * 0.9 + 0.05).requires_grad_(true);
    const Losses losses = losses_of(task, near, truth, mask, training_lights(1));
    EXPECT_GT(losses.map.item<double>(), 1e-3) << name_of(task);
    EXPECT_GT(losses.render.item<double>(), 1e-5) << name_of(task);
    losses.total.backward();
    const Tensor stepped = (near - 1e-3 * near.grad() / near.grad().abs().max()).detach();
    EXPECT_LT(losses_of(task, stepped, truth, mask, training_lights(1)).total.item<double>(),
              losses.total.item<double>())
        << name_of(task);
  }
}

TEST(Losses, CountTheForegroundOnly) {
  const MaterialMaps truth = random_maps(1, 16, 16, torch::kFloat, 5);
  Tensor mask = torch::ones({1, 1, 16, 16});
  mask.slice(3, 0, 8).fill_(0);
  Tensor output = encoded_maps(Task::kRss, truth).clone();
  output.slice(3, 0, 8).fill_(0.77);
  EXPECT_NEAR(losses_of(Task::kRss, output, truth, mask, training_lights(1)).total.item<double>(), 0, 1e-6);
}

TEST(Losses, AreNotRenderedForNothing) {
  const MaterialMaps truth = random_maps(1, 16, 16, torch::kFloat, 9);
  const Tensor mask = torch::ones({1, 1, 16, 16});
  LossOptions maps_alone;
  maps_alone.render_weight = 0;
  for (const Task task : kTasks) {
    const Tensor wrong = 0.9 * encoded_maps(task, truth) + 0.05;
    const Losses losses = losses_of(task, wrong, truth, mask, training_lights(1), maps_alone);
    const Losses rendered = losses_of(task, wrong, truth, mask, training_lights(1));
    EXPECT_EQ(losses.render.item<float>(), 0) << name_of(task);
    EXPECT_EQ(losses.total.item<float>(), rendered.map.item<float>()) << name_of(task);
    EXPECT_GT(rendered.render.item<float>(), 0) << name_of(task);
  }
}

// A wrong normal, by the roughness asked for and by surfaces that have it.
TEST(Losses, OfNormalsAreRenderedWithTheControlRoughness) {
  const MaterialMaps truth = random_maps(1, 16, 16, torch::kFloat, 8);
  const Tensor mask = torch::ones({1, 1, 16, 16});
  const auto lights = training_lights(1);
  const Tensor wrong = 0.8 * encoded_maps(Task::kGeometry, truth) + 0.1;
  for (const double roughness : {0.3, 0.8}) {
    LossOptions options;
    options.control_roughness = roughness;
    const auto with_it = [&](MaterialMaps maps) {
      maps.roughness.fill_(roughness), maps.specular.fill_(0.5);
      return maps;
    };
    EXPECT_NEAR(losses_of(Task::kGeometry, wrong, truth, mask, lights, options).render.item<double>(),
                fused_rendering_loss(
                    with_it(maps_of(Task::kGeometry, wrong, random_maps(1, 16, 16, torch::kFloat, 8))),
                    with_it(random_maps(1, 16, 16, torch::kFloat, 8)), mask, lights)
                    .item<double>(),
                1e-6)
        << roughness;
  }
}

// Each part is judged as its prior would be, whatever the other parts are.
TEST(Losses, OfTheJointNetworkAreThoseOfItsParts) {
  const MaterialMaps truth = random_maps(1, 16, 16, torch::kDouble, 7);
  const Tensor exact = encoded_maps(Task::kJoint, truth), wrong = 0.8 * exact + 0.1;
  const Tensor mask = torch::ones({1, 1, 16, 16}, torch::kDouble);
  const auto lights = training_lights(1);
  double sum = 0;
  int64_t first = 0;
  for (const Task task : kPriorTasks) {
    const int64_t end = first + output_channels(task);
    Tensor output = exact.clone();
    output.slice(1, first, end).copy_(wrong.slice(1, first, end));
    const double prior =
        losses_of(task, wrong.slice(1, first, end), truth, mask, lights).total.item<double>();
    EXPECT_NEAR(losses_of(Task::kJoint, output, truth, mask, lights).total.item<double>(), prior / 3,
                1e-6 * prior)
        << name_of(task);
    sum += prior;
    first = end;
  }
  EXPECT_NEAR(losses_of(Task::kJoint, wrong, truth, mask, lights).total.item<double>(), sum / 3, 1e-6 * sum);
}

/// The map loss of an estimate whose channel `channel` of roughness, S and sss is off by `error` in half of
/// the foreground.
double loss_of_error(Task task, int64_t channel, double error, bool balanced) {
  MaterialMaps truth = random_maps(1, 16, 16, torch::kDouble, 6);
  truth.roughness.fill_(0.25), truth.specular.fill_(0.184), truth.sss.fill_(0);
  Tensor output = encoded_maps(task, truth).clone();
  output.select(1, output.size(1) - 3 + channel).slice(2, 0, 8) += error;
  const Tensor mask = torch::ones({1, 1, 16, 16}, torch::kDouble);
  return losses_of(task, output, truth, mask, training_lights(1), {1, {}, balanced}).map.item<double>();
}

TEST(Losses, BalancedCountsEachMaterialByItsSpan) {
  const double spans[3] = {0.6, 0.079, 0.08};
  for (const Task task : {Task::kRss, Task::kFinetune})
    for (const double part : {0.25, 1.0}) {
      const double roughness = loss_of_error(task, 0, part * spans[0], true);
      // Half of the pixels, one of the channels; absolute and squared part.
      const double channels = static_cast<double>(output_channels(task));
      EXPECT_NEAR(roughness, 0.5 / channels * 0.6 * (part + part * part) / 2, 1e-9) << name_of(task);
      for (int64_t channel = 1; channel < 3; ++channel)
        EXPECT_NEAR(loss_of_error(task, channel, part * spans[channel], true), roughness, 1e-9);
      // As the paper counts, a whole skin taken for cloth is an eighth of a whole fabric taken for leather.
      EXPECT_NEAR(loss_of_error(task, 2, spans[2], false) / loss_of_error(task, 0, spans[0], false),
                  0.08 / 0.6, 1e-6);
    }
}

}  // namespace
}  // namespace ohb
