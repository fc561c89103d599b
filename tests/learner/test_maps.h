// Material maps made in memory.
#pragma once

#include "learner/oracle.h"

namespace ohb {
using namespace learner;

/// Maps like those of a subject: normals towards the viewer (a hemisphere's, with noise), every value a
/// function of `seed`.
inline MaterialMaps random_maps(int64_t batch, int64_t height, int64_t width, torch::Dtype type,
                                uint64_t seed) {
  auto generator = at::detail::createCPUGenerator(seed);
  const auto uniform = [&](int64_t channels, double low, double high) {
    return (torch::rand({batch, channels, height, width}, generator, torch::kDouble) * (high - low) + low)
        .to(type);
  };
  MaterialMaps maps;
  torch::Tensor n = uniform(3, -0.8, 0.8);
  n.select(1, 2).copy_(uniform(1, 0.15, 1.2).select(1, 0));
  maps.normal = unit_normals(n);
  maps.diffuse = uniform(3, 0.02, 0.9);
  maps.roughness = uniform(1, 0.2, 0.9);
  maps.specular = uniform(1, 0.1, 0.6);
  maps.sss = uniform(1, 0, 0.3);
  maps.displacement = uniform(1, -0.3, 0.3);
  return maps;
}

/// The six maps, in order.
inline std::vector<torch::Tensor*> tensors_of(MaterialMaps& maps) {
  return {&maps.normal, &maps.diffuse, &maps.roughness, &maps.specular, &maps.sss, &maps.displacement};
}

inline void require_gradients(MaterialMaps& maps) {
  for (torch::Tensor* map : tensors_of(maps)) *map = map->detach().clone().requires_grad_(true);
}

inline constexpr const char* kMapNames[] = {"normal",   "diffuse", "roughness",
                                            "specular", "sss",     "displacement"};

}  // namespace ohb
