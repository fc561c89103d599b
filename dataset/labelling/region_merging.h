// Merges faces to regions of one look (see find_garments).
#pragma once

#include <map>
#include <queue>
#include <vector>

#include "dataset/labelling/face_features.h"

namespace ohb::labelling {

class RegionMerging {
 public:
  /// `is_in`: the faces that count, of each. `look`: of each face.
  RegionMerging(const FaceGraph& graph, const std::vector<float>& likeness, const std::vector<bool>& is_in,
                const std::vector<Appearance>& look);

  /// Merges the pair of least cost while that is below `most_cm`.
  void merge_below(float most_cm);
  /// Merges regions below `least_cm2` into the neighbour of least cost, the smallest first.
  void merge_crumbs(float least_cm2);

  /// The face that stands for the face's region.
  uint32_t region_of(uint32_t face);
  float area_cm2(uint32_t region) const { return area_[region]; }
  Appearance look(uint32_t region) const { return look_sum_[region] / area_[region]; }

 private:
  struct Pair {
    float cost;
    uint32_t a, b, version_a, version_b;
    bool operator>(const Pair& o) const { return std::tie(cost, a, b) > std::tie(o.cost, o.a, o.b); }
  };
  float cost(uint32_t a, uint32_t b, float border_cm) const;
  void propose(uint32_t a, uint32_t b, float border_cm);
  uint32_t merge(uint32_t a, uint32_t b);

  std::vector<uint32_t> parent_, version_;
  std::vector<float> area_;
  std::vector<Appearance> look_sum_;
  std::vector<std::map<uint32_t, float>> border_cm_;  // of each region with its neighbours
  std::priority_queue<Pair, std::vector<Pair>, std::greater<Pair>> open_;
};

}  // namespace ohb::labelling
