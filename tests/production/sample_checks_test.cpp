#include "dataset/production/sample_checks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace ohb::production {
namespace {

constexpr int kSize = 16;
constexpr MaterialTable kTable = {
    {{0.184f, 0.4f, 0.08f}, {0.239f, 0.5f, 0}, {0.263f, 0.85f, 0}, {0.224f, 0.25f, 0}}};

/// Somebody in the middle of the picture, all skin, lit evenly with noise of this standard deviation.
Sample good_sample(double noise = 0, unsigned seed = 1) {
  Sample s;
  s.mask = Image(kSize, kSize, 1);
  s.normal = s.diffuse = Image(kSize, kSize, 3);
  s.roughness = s.specular = s.sss = s.displacement = Image(kSize, kSize, 1);
  s.classes = Image(kSize, kSize, 4);
  s.lights.push_back({"noon", Image(kSize, kSize, 3)});
  s.attributes = {{"ohb:displacementRange_cm", "100"}};
  std::mt19937 dice(seed);
  std::normal_distribution<float> error(1, static_cast<float>(noise));
  for (int y = 4; y < 12; ++y)
    for (int x = 4; x < 12; ++x) {
      *s.mask.pixel(x, y) = 1;
      s.normal.pixel(x, y)[2] = 1;
      for (int c = 0; c < 3; ++c)
        s.diffuse.pixel(x, y)[c] = 0.5f, s.lights[0].radiance.pixel(x, y)[c] = error(dice);
      *s.specular.pixel(x, y) = 0.184f;
      *s.roughness.pixel(x, y) = 0.4f;
      *s.sss.pixel(x, y) = 0.08f;
      s.classes.pixel(x, y)[0] = 1;
    }
  return s;
}

TEST(SampleChecks, AGoodSampleHasNoFaults) {
  EXPECT_TRUE(sample_faults(good_sample(), kTable).empty());
  EXPECT_DOUBLE_EQ(class_pixels(good_sample())[kSkin], 64);
}

TEST(SampleChecks, EachFaultIsNamed) {
  struct Case {
    std::function<void(Sample&)> spoil;
    const char* words;
  };
  const Case cases[] = {
      {[](Sample& s) { *s.mask.pixel(5, 5) = 1.5f; }, "mask is outside [0, 1] at pixel (5, 5)"},
      {[](Sample& s) { s.normal.pixel(6, 7)[2] = 0.9f; }, "normal is not of unit length at pixel (6, 7)"},
      {[](Sample& s) { s.diffuse.pixel(6, 7)[1] = 1.1f; }, "diffuse is outside"},
      {[](Sample& s) { *s.roughness.pixel(6, 7) = 0.2f; }, "roughness is outside [0.25, 0.85]"},
      {[](Sample& s) { *s.specular.pixel(6, 7) = 0.5f; }, "specular is outside"},
      {[](Sample& s) { *s.sss.pixel(6, 7) = 0.2f; }, "sss is outside"},
      {[](Sample& s) { s.classes.pixel(6, 7)[1] = 0.5f; }, "shares of the classes"},
      {[](Sample& s) { *s.displacement.pixel(6, 7) = 500; }, "displacement is outside"},
      {[](Sample& s) { *s.roughness.pixel(0, 0) = 0.4f; },
       "roughness is not 0 outside the mask at pixel (0, 0)"},
      {[](Sample& s) { s.lights[0].radiance.pixel(0, 3)[0] = 1; }, "relit.noon is not 0 away from the mask"},
      {[](Sample& s) { s.lights[0].radiance.pixel(6, 7)[0] = -1; }, "relit.noon is negative"},
      {[](Sample& s) {
         for (float& v : s.lights[0].radiance.values) v = 0;
       },
       "relit.noon is black"},
      {[](Sample& s) { s.lights.clear(); }, "no lit image"},
  };
  for (const Case& c : cases) {
    Sample sample = good_sample();
    c.spoil(sample);
    const std::vector<std::string> faults = sample_faults(sample, kTable);
    ASSERT_EQ(faults.size(), 1u) << c.words;
    EXPECT_NE(faults[0].find(c.words), std::string::npos) << faults[0];
  }
}

TEST(SampleChecks, NoiseIsNoDifferenceAndAnotherLightIs) {
  for (unsigned seed = 1; seed < 40; seed += 3) {
    const Sample a = good_sample(0.3, seed), b = good_sample(0.3, seed + 1);
    Sample stored = good_sample(0.3, seed + 2);
    EXPECT_TRUE(rerender_faults(stored, a, b, 32, 32).empty()) << seed;
    for (float& v : stored.lights[0].radiance.values) v *= 1.8f;
    EXPECT_EQ(rerender_faults(stored, a, b, 32, 32).size(), 1u) << seed;
  }
  // With less noise less is found.
  const Sample a = good_sample(0.01, 1), b = good_sample(0.01, 2);
  Sample stored = good_sample(0.01, 3);
  for (float& v : stored.lights[0].radiance.values) v *= 1.08f;
  EXPECT_EQ(rerender_faults(stored, a, b, 32, 32).size(), 1u);
}

TEST(SampleChecks, MapsMustBeTheSame) {
  const Sample a = good_sample();
  Sample stored = good_sample();
  for (int x = 4; x < 12; ++x) stored.roughness.pixel(x, 8)[0] = 0.5f;
  const std::vector<std::string> faults = rerender_faults(stored, a, a, 32, 32);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_NE(faults[0].find("8 of 256 values of roughness"), std::string::npos) << faults[0];
}

}  // namespace
}  // namespace ohb::production
