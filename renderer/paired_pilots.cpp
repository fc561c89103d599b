#include "renderer/paired_pilots.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/student_t.h"

namespace ohb::renderer {
namespace {

constexpr uint64_t kPairSeeds = 0x70616972ull;

/// Sums over values of products of two images' values: enough for the U statistic of any subset of images.
struct Products {
  std::vector<double> own;  // of each image with itself
  std::vector<double> all;  // of each image with the sum of all
  explicit Products(size_t images) : own(images, 0.0), all(images, 0.0) {}

  void add(const std::vector<double>& values) {
    double sum = 0;
    for (const double v : values) sum += v;
    for (size_t k = 0; k < values.size(); ++k) own[k] += values[k] * values[k], all[k] += values[k] * sum;
  }
  void add(const Products& other, double sign) {
    for (size_t k = 0; k < own.size(); ++k) own[k] += sign * other.own[k], all[k] += sign * other.all[k];
  }
  /// Mean product of two different images, without image `left_out` (or with all: -1).
  double mean(int left_out) const {
    double pairs = 0, n = static_cast<double>(own.size());
    for (size_t k = 0; k < own.size(); ++k) pairs += all[k] - own[k];
    if (left_out >= 0) {
      const size_t k = static_cast<size_t>(left_out);
      pairs -= 2 * (all[k] - own[k]);
      n -= 1;
    }
    return pairs / (n * (n - 1));
  }
};

constexpr size_t kGroups = 16;  // of pixels

double ratio(const Products& difference, const Products& reference, int left_out = -1) {
  const double below = reference.mean(left_out);
  return below > 0 ? difference.mean(left_out) / below : 0;
}

/// Variance of a value that the jackknife tells from the values without each part.
double jackknife(const std::vector<double>& without) {
  const double n = static_cast<double>(without.size());
  double mean = 0, squares = 0;
  for (const double v : without) mean += v / n;
  for (const double v : without) squares += (v - mean) * (v - mean);
  return (n - 1) / n * squares;
}

}  // namespace

std::vector<size_t> pilot_pixels(const Picture& picture, size_t count) {
  std::vector<size_t> pixels;
  const int size = picture.settings.size_px;
  const auto seen = static_cast<size_t>(std::count(picture.seen.begin(), picture.seen.end(), 1));
  const int step =
      std::max(1, static_cast<int>(std::sqrt(static_cast<double>(seen) / static_cast<double>(count))));
  for (int y = step / 2; y < size; y += step)
    for (int x = step / 2; x < size; x += step) {
      const size_t pixel = static_cast<size_t>(y) * size + x;
      if (picture.seen[pixel]) pixels.push_back(pixel);
    }
  return pixels;
}

PilotStack render_pilot_stack(const Picture& picture, const std::vector<size_t>& pixels, int images, int spp,
                              RenderStatistics& statistics, const PixelsDone& done) {
  std::vector<uint32_t> budget(picture.seen.size(), 0);
  for (const size_t pixel : pixels) budget[pixel] = static_cast<uint32_t>(spp);
  PilotStack stack;
  for (int k = 0; k < images; ++k) {
    const uint64_t seed = mix_bits(mix_bits(picture.settings.seed) ^ (kPairSeeds + static_cast<uint64_t>(k)));
    stack.emplace_back();
    for (const SampleLight& light : render_round(picture, {seed, budget}, statistics, done)) {
      stack.back().emplace_back();
      for (const size_t pixel : pixels)
        for (size_t c = 0; c < 3; ++c) stack.back().back().push_back(light.radiance.values[3 * pixel + c]);
    }
  }
  return stack;
}

SquaredDifference squared_difference(const PilotStack& a, size_t light_a, const PilotStack& b, size_t light_b,
                                     double alpha) {
  const size_t images = a.size(), values = a[0][light_a].size();
  Products difference(images), reference(images);
  std::vector<Products> differences(kGroups, difference), references(kGroups, reference);
  std::vector<double> here(images), apart(images);
  for (size_t i = 0; i < values; ++i) {
    for (size_t k = 0; k < images; ++k) {
      here[k] = a[k][light_a][i];
      apart[k] = b[k][light_b][i] - here[k];
    }
    references[i / 3 % kGroups].add(here);
    differences[i / 3 % kGroups].add(apart);
  }
  for (size_t g = 0; g < kGroups; ++g) reference.add(references[g], 1), difference.add(differences[g], 1);
  if (std::all_of(difference.own.begin(), difference.own.end(), [](double own) { return own == 0; }))
    return {};
  if (!(reference.mean(-1) > 0))  // the noise hides whether there is light at all
    return {std::numeric_limits<double>::infinity(), 0, std::numeric_limits<double>::infinity()};
  std::vector<double> without_image, without_group;
  for (size_t k = 0; k < images; ++k)
    without_image.push_back(ratio(difference, reference, static_cast<int>(k)));
  for (size_t g = 0; g < kGroups; ++g) {
    Products d = difference, r = reference;
    d.add(differences[g], -1), r.add(references[g], -1);
    without_group.push_back(ratio(d, r));
  }
  const double reach = student_two_sided_quantile(alpha, static_cast<double>(images - 1)) *
                       std::sqrt(jackknife(without_image) + jackknife(without_group));
  const double value = ratio(difference, reference);
  return {value, value - reach, value + reach};
}

}  // namespace ohb::renderer
