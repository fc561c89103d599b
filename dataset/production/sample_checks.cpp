#include "dataset/production/sample_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "dataset/model/map_table.h"

namespace ohb::production {
namespace {

constexpr float kUnit = 2e-3f, kHalf = 2e-3f;  // of normals, and of values that are stored as halves
constexpr int kGrid = 8;
constexpr double kMapPixels = 1e-3;  // that may differ: borders fall either way on other processors

/// Goes over pixels and remembers the first that is wrong, and how many are.
class Count {
 public:
  void operator()(bool is_wrong, int x, int y) {
    if (is_wrong && count_++ == 0) x_ = x, y_ = y;
  }
  void add_to(std::vector<std::string>& faults, const std::string& what) const {
    if (count_ > 0)
      faults.push_back(fmt::format("{} at pixel ({}, {}){}", what, x_, y_,
                                   count_ > 1 ? fmt::format(" and {} more", count_ - 1) : ""));
  }

 private:
  size_t count_ = 0;
  int x_ = 0, y_ = 0;
};

using IsWrong = std::function<bool(const float* value, float mask)>;

void check(const Sample& sample, const Image& image, const std::string& what,
           std::vector<std::string>& faults, const IsWrong& is_wrong) {
  Count count;
  for (int y = 0; y < image.height_px; ++y)
    for (int x = 0; x < image.width_px; ++x)
      count(is_wrong(image.pixel(x, y), *sample.mask.pixel(x, y)), x, y);
  count.add_to(faults, what);
}

float frame_cm(const Sample& sample) {
  for (const auto& [name, value] : sample.attributes)
    if (name == "ohb:displacementRange_cm") return std::strtof(value.c_str(), nullptr);
  return 0;
}

void check_outside(const Sample& sample, const Image& image, const std::string& name,
                   std::vector<std::string>& faults) {
  check(sample, image, name + " is not 0 outside the mask", faults, [&](const float* value, float mask) {
    for (int c = 0; c < image.channels; ++c)
      if (mask == 0 && value[c] != 0) return true;
    return false;
  });
}

/// Of one channel, inside the mask.
void check_range(const Sample& sample, const Image& image, const std::string& name, float low, float high,
                 std::vector<std::string>& faults) {
  check(sample, image, fmt::format("{} is outside [{:g}, {:g}]", name, low, high), faults,
        [&](const float* value, float mask) {
          for (int c = 0; c < image.channels; ++c)
            if (mask > 0 && (value[c] < low - kHalf || value[c] > high + kHalf)) return true;
          return false;
        });
}

void check_materials(const Sample& sample, const MaterialTable& table, std::vector<std::string>& faults) {
  for (const MaterialMap& map : kMaterialMaps) {
    const auto [low, high] = std::minmax_element(
        table.begin(), table.end(),
        [&](const ClassMaterial& a, const ClassMaterial& b) { return a.*map.value < b.*map.value; });
    check_range(sample, sample.*map.pixels, map.name, (*low).*map.value, (*high).*map.value, faults);
  }
}

/// Whether the mask is 0 at the pixel and all around it.
bool is_far_outside(const Image& mask, int x, int y) {
  for (int v = std::max(0, y - 1); v <= std::min(mask.height_px - 1, y + 1); ++v)
    for (int u = std::max(0, x - 1); u <= std::min(mask.width_px - 1, x + 1); ++u)
      if (*mask.pixel(u, v) > 0) return false;
  return true;
}

/// Beside the mask a path may meet what its grid of 8 x 8 points missed.
void check_background(const Sample& sample, const Image& light, const std::string& name,
                      std::vector<std::string>& faults) {
  Count count;
  for (int y = 0; y < light.height_px; ++y)
    for (int x = 0; x < light.width_px; ++x) {
      const float* value = light.pixel(x, y);
      const bool is_lit = value[0] != 0 || value[1] != 0 || value[2] != 0;
      count(is_lit && is_far_outside(sample.mask, x, y), x, y);
    }
  count.add_to(faults, name + " is not 0 away from the mask");
}

void check_light(const Sample& sample, const SampleLight& light, std::vector<std::string>& faults) {
  const std::string name = "relit." + light.name;
  const std::vector<float>& values = light.radiance.values;
  const float largest = values.empty() ? 0 : *std::max_element(values.begin(), values.end());
  if (largest <= 0) faults.push_back(name + " is black everywhere");
  check_background(sample, light.radiance, name, faults);
  check(sample, light.radiance, name + " is negative", faults, [&](const float* value, float) {
    return std::min({value[0], value[1], value[2]}) < 0;
  });
}

/// Means over a coarse grid, 3 values a cell.
std::vector<double> coarse(const Image& image) {
  std::vector<double> cells(3 * kGrid * kGrid);
  for (int y = 0; y < image.height_px; ++y)
    for (int x = 0; x < image.width_px; ++x) {
      const int cell = y * kGrid / image.height_px * kGrid + x * kGrid / image.width_px;
      for (int c = 0; c < 3; ++c) cells[static_cast<size_t>(3 * cell + c)] += image.pixel(x, y)[c];
    }
  return cells;
}

void compare_maps(const Sample& stored, const Sample& again, std::vector<std::string>& faults) {
  for (const SampleMap& map : sample_maps()) {
    const float tolerance = map.image == &Sample::normal         ? 1e-3f
                            : map.image == &Sample::displacement ? 1e-2f
                                                                 : kHalf;
    const Image &a = stored.*map.image, &b = again.*map.image;
    size_t different = 0;
    for (size_t i = 0; i < a.values.size(); ++i)
      different += i >= b.values.size() || std::abs(a.values[i] - b.values[i]) > tolerance;
    if (static_cast<double>(different) > kMapPixels * static_cast<double>(a.values.size()))
      faults.push_back(fmt::format("{} of {} values of {} are others when rendered again", different,
                                   a.values.size(), map.name));
  }
}

}  // namespace

std::vector<std::string> sample_faults(const Sample& sample, const MaterialTable& table) {
  std::vector<std::string> faults;
  const auto& mask = sample.mask.values;
  if (std::none_of(mask.begin(), mask.end(), [](float m) { return m > 0; }))
    faults.emplace_back("the mask is empty: nobody is in the picture");
  check(sample, sample.mask, "mask is outside [0, 1]", faults,
        [](const float* value, float) { return !(*value >= 0 && *value <= 1); });
  check(sample, sample.normal, "normal is not of unit length", faults, [](const float* n, float m) {
    return m > 0 && std::abs(std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) - 1) > kUnit;
  });
  check_range(sample, sample.diffuse, "diffuse", 0, 1, faults);
  check_materials(sample, table, faults);
  check(sample, sample.classes, "shares of the classes do not add to 1", faults, [](const float* c, float m) {
    return m > 0 && std::abs(std::accumulate(c, c + kClassCount, -1.0f)) > kClassCount * kHalf;
  });
  if (const float frame = frame_cm(sample); frame > 0)
    check_range(sample, sample.displacement, "displacement", -2 * frame, 2 * frame, faults);
  for (const SampleMap& map : sample_maps())
    if (map.image != &Sample::mask) check_outside(sample, sample.*map.image, map.name, faults);
  if (sample.lights.empty()) faults.emplace_back("there is no lit image");
  for (const SampleLight& light : sample.lights) check_light(sample, light, faults);
  return faults;
}

std::array<double, kClassCount> class_pixels(const Sample& sample) {
  std::array<double, kClassCount> pixels{};
  for (size_t i = 0; i < sample.mask.values.size(); ++i)
    for (size_t c = 0; c < kClassCount; ++c)
      pixels[c] += static_cast<double>(sample.mask.values[i] * sample.classes.values[kClassCount * i + c]);
  return pixels;
}

std::vector<std::string> rerender_faults(const Sample& stored, const Sample& a, const Sample& b, int spp,
                                         int stored_spp) {
  std::vector<std::string> faults;
  compare_maps(stored, a, faults);
  for (size_t k = 0; k < std::min(stored.lights.size(), a.lights.size()); ++k) {
    if (stored.lights[k].name != a.lights[k].name) {
      faults.push_back("light " + std::to_string(k) + " is " + stored.lights[k].name + ", not " +
                       a.lights[k].name);
      continue;
    }
    const std::vector<double> s = coarse(stored.lights[k].radiance), x = coarse(a.lights[k].radiance),
                              y = coarse(b.lights[k].radiance);
    double difference = 0, noise = 0, power = 0;
    for (size_t i = 0; i < s.size(); ++i) {
      difference += std::pow(s[i] - (x[i] + y[i]) / 2, 2);
      noise += std::pow(x[i] - y[i], 2) / 4;  // of the mean of two
      power += std::pow((x[i] + y[i]) / 2, 2);
    }
    const double of_stored = stored_spp > 0 ? 2.0 * spp / stored_spp : 2;
    const double relative = std::sqrt(difference / std::max(power, 1e-300)),
                 expected = std::sqrt(noise * (1 + of_stored) / std::max(power, 1e-300));
    if (relative > 0.03 + 3 * expected)
      faults.push_back(
          fmt::format("relit.{} differs by {:.3g} from what is rendered again, where noise explains {:.3g}",
                      stored.lights[k].name, relative, expected));
  }
  if (stored.lights.size() != a.lights.size()) faults.emplace_back("the number of lights is another one");
  return faults;
}

}  // namespace ohb::production
