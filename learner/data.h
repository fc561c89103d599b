// Samples as tensors: the dataset's index, the split by person, and one view under one light as the networks
// see it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dataset/model/camera.h"
#include "dataset/model/sample.h"
#include "learner/maps.h"
#include "learner/window.h"

namespace ohb::learner {

struct Person {
  std::string name;                          // ohb:human of the samples
  std::vector<std::filesystem::path> views;  // sorted
  std::vector<std::string> identities = {};  // one a view: a hash of all its attributes
};

/// A folder that holds, at any depth, folders with view_*.exr as `openhumanbrdf render` writes them.
struct Dataset {
  std::filesystem::path folder;
  std::vector<Person> people;  // sorted by name
};

/// Reads the index; of each folder the first view is read whole, of the others the header. Where render.json
/// lists the views of a folder, view files that it does not list or that are of other settings are left out,
/// with a warning. Elsewhere (made by hand, or by a version before identities) all views of a folder must
/// agree. Throws InputError: no such folder, no view in it, a broken first view or header, views of one
/// folder that are of different settings.
Dataset read_dataset(const std::filesystem::path& folder);

/// A hash of which views these people have and what their headers say: of the samples that a run trains on.
std::string identity_of_views(const Dataset& dataset, const std::vector<std::string>& people);

struct Split {
  std::vector<std::string> training, held_out;  // names of people, sorted
};

/// No person is on both sides. `held_out` names people; if it is empty, every fourth person (at least one,
/// where there are two or more) is held out, in an order that is a function of `seed` and the names.
/// Throws InputError for a name that is not in the dataset, and if nobody is left to train on.
Split split_people(const Dataset& dataset, const std::vector<std::string>& held_out, uint64_t seed);

/// All views of these people, in order.
std::vector<std::filesystem::path> views_of(const Dataset& dataset, const std::vector<std::string>& people);

/// One view under one light; a batch of one.
struct Example {
  std::string name;         // "<file> under <light>", for messages and logs
  std::string person;       // ohb:human, or the folder's name
  torch::Tensor input;      // (1, 4, H, W): see network_input
  torch::Tensor mask;       // (1, 1, H, W), coverage in [0, 1]
  MaterialMaps truth;       // normals of unit length; displacement over the half frame; background 0
  float half_frame_cm = 0;  // displacement in cm = displacement x half_frame_cm
};

/// Photographs are exposed so that this share of the foreground is no brighter than this level (linear).
constexpr double kExposedPercentile = 0.95;
constexpr float kExposedLevel = 0.8f;

/// `light_key` chooses the light: number light_key mod the number of lights.
///
/// The input is made as a photograph would be: the light's radiance over its coverage, exposed so that the
/// 95th percentile of the foreground's largest channel becomes 0.8, clipped to [0, 1], sRGB-encoded, times
/// the coverage. Views larger than size_px by a whole factor are averaged down, maps weighted by coverage.
/// Throws InputError naming `file`: not square, no whole multiple of size_px, no foreground, no light,
/// ohb:displacementRange_cm missing or not above 0, a normal of length 0 in the foreground.
///
/// `part`: that window of the view alone, as if it had been the frame: displacement counts in its half.
Example example_of(const Sample& sample, const std::filesystem::path& file, uint64_t light_key, int size_px,
                   const std::optional<Window>& part = {});

/// Keys of what makes more examples of a view; 0: that is left out.
struct Variations {
  uint64_t part = 0;     // of drawn_window, where the view is larger than size_px
  uint64_t mixture = 0;  // of mixed_light
};

/// read_sample and example_of.
Example read_example(const std::filesystem::path& file, uint64_t light_key, int size_px,
                     const Variations& keys = {});

/// The camera that a sample was rendered by. Throws InputError naming `file` and the ohb:camera... attribute
/// that is missing or no number.
Camera camera_of(const Sample& sample, const std::filesystem::path& file);

/// (B, 4, H, W) from an sRGB-encoded foreground (B, 3, H, W) that is already multiplied by the mask
/// (B, 1, H, W): 2 x - 1 of both.
torch::Tensor network_input(const torch::Tensor& srgb, const torch::Tensor& mask);

}  // namespace ohb::learner
