// What the faces of a class look like on this person: a mixture of Gaussians of colour and texture.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Dense>

namespace ohb::labelling {

/// L*, a*, b*, and the logarithm of the spread of L* in and around a face.
constexpr int kAppearanceCount = 4;
using Appearance = Eigen::Matrix<float, kAppearanceCount, 1>;

class ColourModel {
 public:
  /// Up to kComponents Gaussians with full covariance by expectation maximisation, from samples with weights
  /// >= 0. Starts at the samples that lie farthest from each other, so it is a function of its arguments.
  /// Without any weight every appearance is equally (un)likely.
  ColourModel(const std::vector<Appearance>& samples, const std::vector<float>& weights);

  /// Logarithm of the density.
  float log_density(const Appearance& appearance) const;
  bool empty() const { return components_.empty(); }

  static constexpr int kComponents = 4;

 private:
  struct Component {
    Appearance mean;
    Eigen::Matrix<float, kAppearanceCount, kAppearanceCount>
        root;  // whitens: |root (x - mean)| is the distance
    float log_scale;
  };
  void fit(const std::vector<Appearance>& samples, const std::vector<float>& weights);
  std::vector<Component> components_;
};

}  // namespace ohb::labelling
