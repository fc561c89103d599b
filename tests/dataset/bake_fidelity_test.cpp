// A picture with baked maps equals one with the scan's own materials, and stops doing so where the maps are
// too small.
#include "dataset/studies/bake_fidelity.h"

#include <gtest/gtest.h>

#include <cmath>

#include "dataset/commands/label.h"
#include "dataset/commands/source_materials.h"
#include "tests/support/paths.h"
#include "tests/support/shared_data.h"
#include "tests/support/tube_person.h"

namespace ohb {
using namespace bake;
using namespace commands;
using namespace labelling;
using namespace studies;
using namespace surface;
using namespace validation;
namespace {

namespace fs = std::filesystem;

/// Grey towards the horizon, a bright patch at the upper left.
Environment patch_of_light() {
  Environment environment;
  environment.name = "patch";
  environment.radiance = Image(32, 16, 3);
  for (float& value : environment.radiance.values) value = 0.4f;
  for (int y = 3; y < 6; ++y)
    for (int x = 20; x < 25; ++x)
      for (int c = 0; c < 3; ++c) environment.radiance.pixel(x, y)[c] = 12;
  return environment;
}

FidelitySettings small_pictures() {
  FidelitySettings settings;
  settings.size_px = 96;
  settings.spp = 8;
  return settings;
}

std::unique_ptr<BakeInputs> inputs_of(const LabelJob& label) {
  label_scan(label);
  BakeJob job;
  job.scan = label.scan;
  job.regions = label.output;
  job.unit = label.unit;
  job.quiet = true;
  return read_bake_inputs(job);
}

/// The pictures' own size must pass, 1/32 of it must not.
void expect_equal_at_own_size_only(const BakeInputs& inputs) {
  FidelitySettings settings = small_pictures();
  settings.map_sizes_px = {0, largest_picture_px(inputs.scan) / 32};
  const BakeFidelity fidelity = measure_bake_fidelity(inputs, patch_of_light(), settings);
  ASSERT_EQ(fidelity.points.size(), 2u);
  EXPECT_TRUE(fidelity.passes()) << fidelity_text(fidelity);
  EXPECT_GT(fidelity.points[0].bins.bins, 100u);
  EXPECT_LT(fidelity.points[0].relative_error, 0.01);
  EXPECT_FALSE(fidelity.points[1].failures.empty()) << fidelity_text(fidelity);
  EXPECT_GT(fidelity.points[1].relative_error, 10 * fidelity.points[0].relative_error);
}

TEST(BakeFidelity, ExampleHuman) {
  const TemporaryFolder folder;
  const fs::path human = source_path("assets/example_human");
  LabelJob label;
  label.scan = human / "example_human.glb";
  label.faces = human / "example_human.labels.txt";
  label.output = folder / "regions";
  const auto inputs = inputs_of(label);
  ASSERT_FALSE(inputs->options.class_weights.at(0).empty()) << "soft borders";
  expect_equal_at_own_size_only(*inputs);
}

/// Parts with pictures of 512 to 2048 px, cut-outs and normal maps; no weights: each part is of one class.
TEST(BakeFidelity, SharedHumanOfParts) {
  OHB_SHARED_DATA_OR_SKIP(human, "humans/f25_casual");
  const TemporaryFolder folder;
  LabelJob label;
  label.scan = human / "f25_casual.obj";
  label.output = folder / "regions";
  expect_equal_at_own_size_only(*inputs_of(label));
}

/// A person of one tube; its classes change at faces' edges.
struct Tube {
  TubePerson person;
  BakeInputs inputs;
  Tube() {
    make_tube_person(24, 60, person);
    inputs.scan = person.scan;
    inputs.regions = {person.truth, std::string(64, '0')};
    inputs.table = {{{0.184f, 0.4f, 0.08f}, {0.239f, 0.5f, 0}, {0.263f, 0.85f, 0}, {0.224f, 0.25f, 0}}};
    inputs.options.mends_seams = false;
  }
};

TEST(BakeFidelity, UnmendedMapsOfOwnSizeAreTheScansMaterials) {
  const Tube tube;
  FidelitySettings settings = small_pictures();
  settings.size_px = 48;
  const Model source = source_material_model(tube.inputs);
  EXPECT_EQ(source.sets.size(), 4u) << "one a class";
  Model baked = bake_model(tube.inputs.scan, tube.inputs.regions, tube.inputs.table, tube.inputs.options);
  const FidelityPoint same = compare_models(baked, source, patch_of_light(), settings);
  EXPECT_TRUE(same.failures.empty()) << same.failures.front();
  EXPECT_LT(same.relative_error, 0.003) << "only texels at the borders of the classes";
  for (float& value : baked.sets[0].albedo.values) value *= 1.005f;
  EXPECT_FALSE(compare_models(baked, source, patch_of_light(), settings).failures.empty());
}

/// The same mesh with its chart turned by 20 degrees and made smaller, baked from the first through rays.
TEST(BakeFidelity, AnotherUvLayout) {
  const Tube tube;
  BakeInputs other = tube.inputs;
  const double angle = 0.35, scale = 0.7;
  for (Vec2f& uv : other.scan.uvs) {
    const double u = uv.x - 0.5, v = uv.y - 0.5;
    uv = {static_cast<float>(0.5 + scale * (std::cos(angle) * u - std::sin(angle) * v)),
          static_cast<float>(0.5 + scale * (std::sin(angle) * u + std::cos(angle) * v))};
  }
  other.scan.materials[0].diffuse = {};
  other.options.source.scan = &tube.inputs.scan;
  const Model source = source_material_model(tube.inputs);
  FidelitySettings settings = small_pictures();
  settings.size_px = 48;
  const auto failures_at = [&](int map_px) {
    other.options.size_px = map_px;
    const Model baked = bake_model(other.scan, other.regions, other.table, other.options);
    return compare_models(baked, source, patch_of_light(), settings).failures;
  };
  const std::vector<std::string> fine = failures_at(1024);
  EXPECT_TRUE(fine.empty()) << fine.front();
  EXPECT_FALSE(failures_at(32).empty());
}

}  // namespace
}  // namespace ohb
