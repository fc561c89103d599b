#include "learner/data.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "dataset/model/colour.h"
#include "dataset/model/error.h"
#include "learner/hash.h"
#include "learner/light_mixture.h"

namespace ohb::learner {
namespace fs = std::filesystem;
namespace {

constexpr size_t kHeldOutShare = 4;  // one person in four

std::string attribute_of(const Sample& sample, const std::string& name) {
  for (const auto& [key, value] : sample.attributes)
    if (key == name) return value;
  return "";
}

std::string person_of(const Sample& sample, const fs::path& file) {
  const std::string name = attribute_of(sample, "ohb:human");
  return name.empty() ? fs::absolute(file).parent_path().filename().string() : name;
}

uint64_t hash_of(const std::string& text) {
  uint64_t hash = 0;
  for (const char c : text) hash = split_mix(hash ^ static_cast<unsigned char>(c));
  return hash;
}

/// Interleaved pixels to (1, C, H, W), in plain loops: this runs on loader threads, where tensor operations
/// would start teams of threads of their own.
torch::Tensor planar(const Image& image) {
  torch::Tensor tensor = torch::empty({1, image.channels, image.height_px, image.width_px}, torch::kFloat);
  float* out = tensor.data_ptr<float>();
  const size_t pixels = static_cast<size_t>(image.width_px) * image.height_px;
  for (int c = 0; c < image.channels; ++c)
    for (size_t p = 0; p < pixels; ++p) out[c * pixels + p] = image.values[p * image.channels + c];
  return tensor;
}

float exposure_of(const Image& radiance, const Image& mask, const std::string& name) {
  std::vector<float> largest;
  for (size_t p = 0; p < mask.values.size(); ++p)
    if (mask.values[p] > 0.5f)
      largest.push_back(
          std::max({radiance.values[3 * p], radiance.values[3 * p + 1], radiance.values[3 * p + 2]}) /
          mask.values[p]);
  const size_t rank = std::min(largest.size() - 1, static_cast<size_t>(kExposedPercentile * largest.size()));
  std::nth_element(largest.begin(), largest.begin() + static_cast<long>(rank), largest.end());
  if (largest[rank] <= 0)
    throw InputError(name, "", "the foreground is black: nothing is lit", "render it with another light");
  return kExposedLevel / largest[rank];
}

/// The foreground as a photograph: (4, H, W) of sRGB times mask, and mask, as 2 x - 1.
torch::Tensor photograph(const Image& radiance, const Image& mask, const std::string& name) {
  const float exposure = exposure_of(radiance, mask, name);
  Image input(mask.width_px, mask.height_px, 4);
  for (size_t p = 0; p < mask.values.size(); ++p) {
    const float alpha = mask.values[p];
    for (int c = 0; c < 3; ++c) {
      const float linear = alpha > 0 ? exposure * radiance.values[3 * p + c] / alpha : 0;
      input.values[4 * p + c] = 2 * alpha * linear_to_srgb(std::clamp(linear, 0.0f, 1.0f)) - 1;
    }
    input.values[4 * p + 3] = 2 * alpha - 1;
  }
  return planar(input);
}

void check_sample(const Sample& sample, const std::string& file, int size_px) {
  const Image& mask = sample.mask;
  const std::string size = std::to_string(mask.width_px) + " x " + std::to_string(mask.height_px);
  if (mask.width_px != mask.height_px)
    throw InputError(file, "", "is " + size + ", not square", "render the views anew with --size");
  if (mask.width_px < size_px || mask.width_px % size_px != 0)
    throw InputError(file, "",
                     "is " + size + ", which is no whole multiple of --size " + std::to_string(size_px),
                     "choose a --size that divides it and is a multiple of 16");
  if (sample.lights.empty())
    throw InputError(file, "", "holds no lit image", "render it with --environment or --point");
  for (const float value : mask.values)
    if (value < 0 || value > 1)
      throw InputError(file, "part 'mask'", "has coverage outside [0,1]", "render the sample again");
}

void normalise(Image& normal, const Image& mask, const std::string& file) {
  for (size_t p = 0; p < mask.values.size(); ++p) {
    float* n = &normal.values[3 * p];
    const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (mask.values[p] > 0.5f && length < 1e-3f)
      throw InputError(file,
                       "part 'normal', pixel (" + std::to_string(p % mask.width_px) + ", " +
                           std::to_string(p / mask.width_px) + ")",
                       "has length 0 inside the mask", "render the sample again");
    const float scale = length > 0 ? 1 / length : 0;
    for (int c = 0; c < 3; ++c) n[c] *= scale;
  }
}

float number_of(const Sample& sample, const std::string& file, const std::string& name,
                const std::function<bool(float)>& is_right, const std::string& what) {
  const std::string text = attribute_of(sample, name);
  char* end = nullptr;
  const float number = std::strtof(text.c_str(), &end);
  if (end == text.c_str() || !std::isfinite(number) || !is_right(number))
    throw InputError(file, "attribute " + name,
                     text.empty() ? "is missing" : "is '" + text + "', not " + what,
                     "render the sample again with this version");
  return number;
}

float length_of(const Sample& sample, const std::string& file, const std::string& name) {
  return number_of(
      sample, file, name, [](float length) { return length > 0; }, "a length above 0");
}

}  // namespace

Split split_people(const Dataset& dataset, const std::vector<std::string>& held_out, uint64_t seed) {
  std::vector<std::string> names, out = held_out;
  for (const Person& person : dataset.people) names.push_back(person.name);
  for (const std::string& name : held_out)
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw InputError(dataset.folder.string(), "--hold-out " + name, "nobody of that name is in the dataset",
                       "names are the samples' ohb:human");
  if (out.empty() && names.size() >= 2) {
    std::vector<std::string> order = names;
    std::sort(order.begin(), order.end(), [&](const std::string& a, const std::string& b) {
      return key_of({seed, hash_of(a)}) < key_of({seed, hash_of(b)});
    });
    out.assign(order.begin(),
               order.begin() + static_cast<long>(std::max<size_t>(1, names.size() / kHeldOutShare)));
  }
  Split split;
  for (const std::string& name : names)
    (std::find(out.begin(), out.end(), name) == out.end() ? split.training : split.held_out).push_back(name);
  if (split.training.empty())
    throw InputError(dataset.folder.string(), "--hold-out",
                     "everybody is held out: nobody is left to train on", "hold out fewer people");
  return split;
}

Example example_of(const Sample& sample, const fs::path& path, uint64_t light_key, int size_px,
                   const std::optional<Window>& part) {
  const std::string file = path.string();
  check_sample(sample, file, size_px);
  const Window window = part.value_or(Window{0, 0, sample.mask.width_px});
  const SampleLight& light = sample.lights[light_key % sample.lights.size()];
  const Image mask = averaged(sample.mask, nullptr, window, size_px);
  if (std::none_of(mask.values.begin(), mask.values.end(), [](float m) { return m > 0.5f; }))
    throw InputError(file, "part 'mask'", "covers nothing: there is no foreground",
                     "render the sample again");
  Example example;
  example.name = file + " under " + light.name;
  example.person = person_of(sample, path);
  example.half_frame_cm = length_of(sample, file, "ohb:displacementRange_cm") *
                          static_cast<float>(window.side_px) / static_cast<float>(sample.mask.width_px);
  example.input = photograph(averaged(light.radiance, nullptr, window, size_px), mask, example.name);
  example.mask = planar(mask);
  for (const LearnedMap& map : kMaps) {
    Image image = averaged(sample.*map.image, &sample.mask, window, size_px);
    if (map.image == &Sample::normal) normalise(image, mask, file);
    if (map.image == &Sample::displacement)
      for (float& d : image.values) d /= example.half_frame_cm;
    example.truth.*map.tensor = planar(image);
  }
  return example;
}

Example read_example(const fs::path& file, uint64_t light_key, int size_px, const Variations& keys) {
  Sample sample = read_sample(file);
  if (keys.mixture != 0 && !sample.lights.empty()) sample.lights = {mixed_light(sample, keys.mixture)};
  std::optional<Window> part;
  if (keys.part != 0 && sample.mask.width_px > size_px && sample.mask.width_px == sample.mask.height_px)
    part = drawn_window(sample.mask, size_px, keys.part);
  return example_of(sample, file, light_key, size_px, part);
}

Camera camera_of(const Sample& sample, const fs::path& path) {
  const std::string file = path.string();
  Camera camera;
  camera.center_y_cm = number_of(
      sample, file, "ohb:cameraCenterY_cm", [](float) { return true; }, "a number");
  camera.distance_cm = length_of(sample, file, "ohb:cameraDistance_cm");
  camera.half_width = length_of(sample, file, "ohb:cameraHalfWidth");
  return camera;
}

torch::Tensor network_input(const torch::Tensor& srgb, const torch::Tensor& mask) {
  return torch::cat({srgb, mask}, 1) * 2 - 1;
}

}  // namespace ohb::learner
