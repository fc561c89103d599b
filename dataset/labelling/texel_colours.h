// What each class looks like near a place: one Gaussian a class in cells of space.
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>

#include <Eigen/Dense>

#include "dataset/labelling/alpha_expansion.h"
#include "dataset/model/vec.h"

namespace ohb::labelling {

class LocalColours {
 public:
  /// Adds a colour (L*a*b*) that is surely of that class, with its area.
  void add(Vec3f point_cm, uint8_t material_class, Vec3f lab, double area_cm2);
  /// After the last add: what each cell and those around it hold together.
  void fit();
  /// Density of the colour for each class by what lies within kCell_cm to 2 kCell_cm. 0 for a class that does
  /// not occur there, and for one whose colours there cannot be told from those of `own`.
  ClassValues densities_at(Vec3f point_cm, uint8_t own, Vec3f lab) const;
  /// Whether both classes occur there and their colours can be told from each other.
  bool can_tell(Vec3f point_cm, uint8_t one, uint8_t other) const;

  static constexpr float kCell_cm = 3;

 private:
  struct Sums {
    double area = 0;
    Eigen::Vector3d first = Eigen::Vector3d::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  };
  struct Gaussian {
    Eigen::Vector3f mean;
    Eigen::Matrix3f root;
    float scale = 0;  // 0: no such class here
  };
  struct Cell {
    std::array<Gaussian, kClassCount> of;
    std::array<std::array<bool, kClassCount>, kClassCount> can_tell;
  };
  static uint64_t key_of(Vec3f p);
  std::unordered_map<uint64_t, std::array<Sums, kClassCount>> sums_;
  std::unordered_map<uint64_t, Cell> cells_;
};

}  // namespace ohb::labelling
