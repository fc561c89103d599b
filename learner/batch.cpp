#include "learner/batch.h"

#include "learner/hash.h"
#include "learner/recolour.h"
#include "learner/snapshot.h"

namespace ohb::learner {
namespace {

using torch::Tensor;

/// Left and right exchanged: x components of normals change their sign.
void mirror(Example& e) {
  e.input = e.input.flip(3);
  e.mask = e.mask.flip(3);
  for (const LearnedMap& map : kMaps) e.truth.*map.tensor = (e.truth.*map.tensor).flip(3);
  e.truth.normal.select(1, 0).neg_();
}

Batch joined(const std::vector<Example>& examples) {
  const auto all = [&](auto member) {
    std::vector<Tensor> parts;
    parts.reserve(examples.size());
    for (const Example& e : examples) parts.push_back(member(e));
    return parts.size() == 1 ? parts[0] : torch::cat(parts);
  };
  Batch batch;
  batch.names.reserve(examples.size());
  for (const Example& e : examples) batch.names.push_back(e.name);
  batch.input = all([](const Example& e) { return e.input; });
  batch.mask = all([](const Example& e) { return e.mask; });
  for (const LearnedMap& map : kMaps)
    batch.truth.*map.tensor = all([&](const Example& e) { return e.truth.*map.tensor; });
  return batch;
}

}  // namespace

Batch moved_to(const torch::Device& device, Batch batch) {
  batch.input = batch.input.to(device);
  batch.mask = batch.mask.to(device);
  for (const LearnedMap& map : kMaps) batch.truth.*map.tensor = (batch.truth.*map.tensor).to(device);
  return batch;
}

void vary(Example& example, const Augmentation& augmentation, uint64_t position) {
  if (augmentation.mirror_key != 0 && uniform_of(augmentation.mirror_key, position) < 0.5) mirror(example);
  if (augmentation.recolour_key != 0 && uniform_of(augmentation.recolour_key, position) < 0.5)
    recolour(example, key_of({augmentation.recolour_key, position}));
  if (augmentation.snapshot_key != 0) take_snapshot(example, key_of({augmentation.snapshot_key, position}));
}

Batch next_batch(Loader& loader, int size) {
  std::vector<Example> examples;
  examples.reserve(static_cast<size_t>(size));
  for (int i = 0; i < size; ++i) examples.push_back(loader.next());
  return joined(examples);
}

}  // namespace ohb::learner
