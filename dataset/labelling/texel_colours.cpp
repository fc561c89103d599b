#include "dataset/labelling/texel_colours.h"

#include <cmath>

namespace ohb::labelling {
namespace {

/// Added to the variances: no class is narrower than the noise of a picture.
const Eigen::Vector3d kLeastVariance(9, 4, 4);

/// Colours overlap too much below this: means of one variance less than a standard deviation apart.
constexpr double kTelling = 0.125;
constexpr float kOutlier = 1e-6f;           // of a class's highest density
constexpr uint64_t kMask = (1u << 21) - 1;  // of a cell's number along one axis, three in a key

/// Calls visit(key) for a cell and those around it.
template <typename Visit>
void each_around(uint64_t key, const Visit& visit) {
  const auto axis = [&](int shift, int step) {
    return ((key >> shift) + static_cast<uint64_t>(step)) & kMask;
  };
  for (int i = -1; i <= 1; ++i)
    for (int j = -1; j <= 1; ++j)
      for (int k = -1; k <= 1; ++k) visit(axis(42, i) << 42 | axis(21, j) << 21 | axis(0, k));
}

/// Bhattacharyya's distance of two Gaussians: how little they overlap.
double bhattacharyya(const Eigen::Vector3d& mean, const Eigen::Matrix3d& covariance,
                     const Eigen::Vector3d& other_mean, const Eigen::Matrix3d& other_covariance) {
  const Eigen::Matrix3d both = 0.5 * (covariance + other_covariance);
  const Eigen::Vector3d away = mean - other_mean;
  return away.dot(both.ldlt().solve(away)) / 8 +
         0.5 * std::log(both.determinant() /
                        std::sqrt(covariance.determinant() * other_covariance.determinant()));
}

}  // namespace

uint64_t LocalColours::key_of(Vec3f p) {
  uint64_t key = 0;
  for (int i = 0; i < 3; ++i)
    key = key << 21 |
          ((static_cast<uint64_t>(static_cast<int64_t>(std::floor(p[i] / kCell_cm))) + (1 << 20)) & kMask);
  return key;
}

void LocalColours::add(Vec3f point_cm, uint8_t material_class, Vec3f lab, double area_cm2) {
  Sums& sums = sums_[key_of(point_cm)][material_class];
  const Eigen::Vector3d colour(lab.x, lab.y, lab.z);
  sums.area += area_cm2;
  sums.first += area_cm2 * colour;
  sums.second += area_cm2 * colour * colour.transpose();
}

void LocalColours::fit() {
  const auto fit_cell = [&](uint64_t key) {
    Cell& cell = cells_[key];
    std::array<Eigen::Vector3d, kClassCount> mean;
    std::array<Eigen::Matrix3d, kClassCount> covariance;
    for (int c = 0; c < kClassCount; ++c) {
      Sums all;
      each_around(key, [&](uint64_t beside) {
        const auto found = sums_.find(beside);
        if (found == sums_.end()) return;
        all.area += found->second[c].area;
        all.first += found->second[c].first;
        all.second += found->second[c].second;
      });
      if (!(all.area > 0)) continue;
      mean[c] = all.first / all.area;
      covariance[c] = all.second / all.area - mean[c] * mean[c].transpose();
      covariance[c].diagonal() += kLeastVariance;
      const Eigen::Matrix3d lower = covariance[c].llt().matrixL();
      cell.of[c].mean = mean[c].cast<float>();
      cell.of[c].root = lower.inverse().cast<float>();
      cell.of[c].scale = static_cast<float>(1 / lower.diagonal().prod());
    }
    for (int c = 0; c < kClassCount; ++c)
      for (int d = 0; d < kClassCount; ++d)
        cell.can_tell[c][d] =
            c == d || (cell.of[c].scale > 0 && cell.of[d].scale > 0 &&
                       bhattacharyya(mean[c], covariance[c], mean[d], covariance[d]) > kTelling);
  };
  for (const auto& [key, sums] : sums_)
    each_around(key, [&](uint64_t beside) {
      if (cells_.find(beside) == cells_.end()) fit_cell(beside);
    });
}

bool LocalColours::can_tell(Vec3f point_cm, uint8_t one, uint8_t other) const {
  const auto found = cells_.find(key_of(point_cm));
  return found != cells_.end() && found->second.can_tell[one][other];
}

ClassValues LocalColours::densities_at(Vec3f point_cm, uint8_t own, Vec3f lab) const {
  ClassValues density{};
  const auto found = cells_.find(key_of(point_cm));
  if (found == cells_.end()) return density;
  const Eigen::Vector3f colour(lab.x, lab.y, lab.z);
  for (int c = 0; c < kClassCount; ++c) {
    const Gaussian& of = found->second.of[c];
    if (of.scale > 0 && found->second.can_tell[own][c])
      density[c] = of.scale * (kOutlier + std::exp(-0.5f * (of.root * (colour - of.mean)).squaredNorm()));
  }
  return density;
}

}  // namespace ohb::labelling
