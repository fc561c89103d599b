// Where the rendering loss misleads: a normal that cannot be known. Of maps of one albedo whose normals are
// spread evenly to both sides of the viewer's direction, the estimate that says least wrong is that
// direction.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "learner/task.h"
#include "test_maps.h"

namespace ohb {
using namespace learner;
namespace {

using torch::Tensor;

constexpr int64_t kSide_px = 64;
constexpr double kStep = 0.05, kMostTilted = 0.6;  // slopes of the normals that are tried
constexpr double kDegrees = 180 / shading::kPi;

/// Slopes dz/dx and dz/dy drawn from normal distributions with these deviations, each with either sign.
MaterialMaps spread_maps(double deviation_x, double deviation_y) {
  auto generator = at::detail::createCPUGenerator(5);
  const auto slopes = [&](double deviation) {
    return deviation * torch::randn({1, 1, kSide_px / 2, kSide_px / 2}, generator);
  };
  const Tensor x = slopes(deviation_x), y = slopes(deviation_y);
  const Tensor all_x = torch::cat({torch::cat({x, -x}, 3), torch::cat({x, -x}, 3)}, 2);
  const Tensor all_y = torch::cat({torch::cat({y, y}, 3), torch::cat({-y, -y}, 3)}, 2);
  MaterialMaps maps = random_maps(1, kSide_px, kSide_px, torch::kFloat, 1);
  maps.displacement.zero_();
  maps.diffuse.fill_(0.3);
  maps.normal = unit_normals(torch::cat({all_x, all_y, torch::ones_like(all_x)}, 1));
  return maps;
}

/// Angle to the viewer's direction of the one normal whose loss is least, with the materials held so.
double tilt_of_best_deg(const MaterialMaps& truth, double roughness, double specular, double render_weight) {
  MaterialMaps held = truth;
  held.roughness = torch::full_like(truth.roughness, roughness);
  held.specular = torch::full_like(truth.specular, specular);
  const Tensor mask = torch::ones({1, 1, kSide_px, kSide_px});
  const auto lights = training_lights(3);
  double least = std::numeric_limits<double>::infinity(), tilt_deg = 0;
  for (double x = 0; x <= kMostTilted; x += kStep)
    for (double y = 0; y <= kMostTilted; y += kStep) {
      MaterialMaps estimate = held;
      estimate.normal = unit_normals(torch::tensor({x, y, 1.0}, torch::kFloat).view({1, 3, 1, 1}))
                            .expand_as(truth.normal)
                            .contiguous();
      // As losses_of counts them: normals encoded, three of the four channels of geometry.
      double loss = 0.75 * 0.5 * (estimate.normal - truth.normal).abs().mean().item<double>();
      if (render_weight > 0)
        loss += render_weight * fused_rendering_loss(estimate, held, mask, lights, {}).item<double>();
      if (loss < least) least = loss, tilt_deg = std::atan(std::hypot(x, y)) * kDegrees;
    }
  return tilt_deg;
}

// The paper's roughness of 0.2 makes highlights, and where it is not known where they are, the least is lost
// by normals that show none: those out of the two planes of lights.
TEST(UncertainNormals, AreTurnedAwayFromTheLightsByHighlights) {
  EXPECT_GT(tilt_of_best_deg(spread_maps(0.8, 0.4), 0.2, 0.5, 1), 15);
  EXPECT_GT(tilt_of_best_deg(spread_maps(1, 1), 0.2, 0.5, 1), 25);
}

TEST(UncertainNormals, AreLeftAloneByTheMapsAndByRoughSurfaces) {
  for (const auto& [x, y] : {std::pair{0.8, 0.4}, {0.5, 0.3}}) {
    EXPECT_LT(tilt_of_best_deg(spread_maps(x, y), 0.2, 0.5, 0), 3) << "maps alone";
    EXPECT_LT(tilt_of_best_deg(spread_maps(x, y), 0.8, 0.03, 1), 3) << "rough";
    EXPECT_LT(tilt_of_best_deg(spread_maps(x, y), 0.8, 0.5, 1), 3) << "--control-roughness 0.8";
  }
}

}  // namespace
}  // namespace ohb
