// Samples on disk, the camera and environments.
#include "dataset/model/sample.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "dataset/model/atomic_file.h"
#include "dataset/model/camera.h"
#include "dataset/model/environment.h"
#include "tests/support/test_files.h"
#include "tests/support/test_models.h"

namespace ohb {
namespace {

Sample small_sample() {
  Sample sample;
  const auto filled = [](int channels, float start) {
    Image image(6, 5, channels);
    for (size_t i = 0; i < image.values.size(); ++i) image.values[i] = start + static_cast<float>(i) / 256;
    return image;
  };
  sample.mask = filled(1, 0.5f);
  sample.normal = filled(3, -0.1234567f);
  sample.diffuse = filled(3, 0.25f);
  sample.roughness = filled(1, 0.125f);
  sample.specular = filled(1, 0.25f);
  sample.sss = filled(1, 0);
  sample.displacement = filled(1, -33.333333f);
  sample.classes = filled(4, 0);
  sample.lights = {{"forest", filled(3, 1)}, {"point0", filled(3, 2)}};
  sample.attributes = {{"ohb:human", "somebody"}, {"ohb:view", "3"}};
  return sample;
}

TEST(Sample, ReadsBackWhatWasWritten) {
  const TemporaryFolder folder;
  const Sample sample = small_sample();
  write_sample(folder / "view.exr", sample);
  const Sample back = read_sample(folder / "view.exr");
  EXPECT_EQ(back.normal.values, sample.normal.values);
  EXPECT_EQ(back.displacement.values, sample.displacement.values);
  // Multiples of 1/256 are exact in half; the four class channels come back in their order, not by name.
  EXPECT_EQ(back.diffuse.values, sample.diffuse.values);
  EXPECT_EQ(back.classes.values, sample.classes.values);
  ASSERT_EQ(back.lights.size(), 2u);
  EXPECT_EQ(back.lights[1].name, "point0");
  EXPECT_EQ(back.lights[0].radiance.values, sample.lights[0].radiance.values);
  EXPECT_EQ(back.attributes, sample.attributes);
}

TEST(Sample, RadianceBelowZeroIsWrittenAsZero) {
  const TemporaryFolder folder;
  Sample sample = small_sample();
  sample.lights[0].radiance.values[4] = -0.25F;
  write_sample(folder / "view.exr", sample);
  const Sample back = read_sample(folder / "view.exr");
  sample.lights[0].radiance.values[4] = 0;
  EXPECT_EQ(back.lights[0].radiance.values, sample.lights[0].radiance.values);
  EXPECT_LT(back.normal.values[0], 0);
}

TEST(Sample, EqualSamplesGiveEqualBytes) {
  const TemporaryFolder folder;
  write_sample(folder / "a.exr", small_sample());
  ::usleep(1100000);  // a time stamp of seconds would differ
  write_sample(folder / "b.exr", small_sample());
  EXPECT_EQ(read_file(folder / "a.exr"), read_file(folder / "b.exr"));
}

TEST(Sample, RefusesMissingPartsNanAndCutFiles) {
  const TemporaryFolder folder;
  write_exr(folder / "mask.exr", {{"mask", {"A"}, ExrPart::Type::kHalf, Image(4, 4, 1)}}, {});
  expect_message(input_error_of([&] { read_sample(folder / "mask.exr"); }),
                 {"mask.exr", "normal", "missing"});

  Sample sample = small_sample();
  sample.normal.values[10] = std::numeric_limits<float>::quiet_NaN();
  write_sample(folder / "nan.exr", sample);
  expect_message(input_error_of([&] { read_sample(folder / "nan.exr"); }),
                 {"nan.exr", "normal", "pixel (3, 0)", "NaN"});

  const std::string bytes = read_file(folder / "nan.exr");
  for (const double share : {0.0, 0.05, 0.3, 0.7, 0.98}) {
    write_file_atomically(folder / "cut.exr",
                          bytes.substr(0, static_cast<size_t>(share * static_cast<double>(bytes.size()))));
    expect_message(input_error_of([&] { read_sample(folder / "cut.exr"); }), {"cut.exr"});
  }
}

TEST(Camera, EveryTurnStaysInFrame) {
  std::vector<Vec3f> positions;
  for (int i = 0; i < 400; ++i)
    positions.push_back({70.0f * std::sin(static_cast<float>(i) * 1.7f), static_cast<float>(i % 180),
                         30.0f * std::cos(static_cast<float>(i) * 0.9f)});
  const Camera camera = fit_camera(positions);
  float widest = 0;
  for (int view = 0; view < 360; ++view)
    for (const Vec3f& p : positions) {
      const Vec3f q = turn_about_y(p, turn_of_view(view, 360));
      const float depth = camera.distance_cm - q.z;
      widest = std::max({widest, std::fabs(q.x) / depth, std::fabs(q.y - camera.center_y_cm) / depth});
    }
  EXPECT_LT(widest, camera.half_width);
  EXPECT_GT(widest, 0.85f * camera.half_width) << "the subject is smaller than it need be";
}

TEST(Camera, TurnsAreRightHanded) {
  const Vec3f turned = turn_about_y({0, 0, 1}, turn_of_view(1, 4));
  EXPECT_NEAR(turned.x, 1, 1e-6);
  EXPECT_NEAR(turned.z, 0, 1e-6);
}

TEST(Environment, RefusesWhatWouldLightNothingOrEverything) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& name, const Image& image) {
    write_exr(folder / name, {{"rgb", {"R", "G", "B"}, ExrPart::Type::kFloat, image}}, {});
    return input_error_of([&] { read_environment(folder / name); });
  };
  Image image = constant_radiance({1, 1, 1});
  image.pixel(3, 2)[1] = std::numeric_limits<float>::quiet_NaN();
  expect_message(refused("nan.exr", image), {"nan.exr", "(3, 2)", "NaN"});
  image.pixel(3, 2)[1] = std::numeric_limits<float>::infinity();
  expect_message(refused("inf.exr", image), {"inf.exr", "(3, 2)", "infinite"});
  image.pixel(3, 2)[1] = -1;
  expect_message(refused("negative.exr", image), {"negative.exr", "negative"});
  expect_message(refused("black.exr", Image(16, 8, 3)), {"black.exr", "all black"});
  expect_message(refused("square.exr", Image(8, 8, 3)), {"square.exr", "8 x 8", "2:1"});
  expect_message(input_error_of([&] { read_environment(folder / "nowhere.exr"); }),
                 {"nowhere.exr", "no such file"});
  write_file_atomically(folder / "empty.exr", "");
  expect_message(input_error_of([&] { read_environment(folder / "empty.exr"); }), {"empty.exr", "0 bytes"});
  expect_message(input_error_of([&] { read_environment(folder.path()); }), {"is a folder"});
}

TEST(Environment, SlightUndershootIsSetToZero) {
  const TemporaryFolder folder;
  Image image = constant_radiance({1, 1, 1});
  image.pixel(3, 2)[1] = -0.003f;
  write_exr(folder / "ringing.exr", {{"rgb", {"R", "G", "B"}, ExrPart::Type::kFloat, image}}, {});
  const Environment environment = read_environment(folder / "ringing.exr");
  EXPECT_EQ(environment.mended_values, 1u);
  EXPECT_EQ(environment.radiance.pixel(3, 2)[1], 0);
  EXPECT_EQ(environment.radiance.pixel(3, 2)[0], 1);
}

}  // namespace
}  // namespace ohb
