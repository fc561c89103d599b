#include "renderer/ggx_energy.h"

#include "dataset/model/parallel.h"
#include "dataset/model/sampling.h"

namespace ohb::renderer {
namespace {

constexpr double kLeast = 1e-4, kMostZ = 0.99;  // the grid's ends stand for these

double lambda(double alpha2, double cosine) {
  return 0.5 * (std::sqrt(1 + alpha2 * (1 / (cosine * cosine) - 1)) - 1);
}

/// A visible normal of one node of the quadrature.
struct Node {
  double cos_oh;  // cosine of viewer and normal
  double passes;  // G2 / G1 of the mirrored direction; 0: it would go under the surface
};

/// The node of the unit square's point in the warp of sample_ggx_visible_normal (Heitz 2018), in double.
Node visible_normal(double alpha, double sine, double cosine, double radius, double phi) {
  const double scale = 1 / std::sqrt(alpha * alpha * sine * sine + cosine * cosine);
  const double vx = alpha * sine * scale, vz = cosine * scale;
  const double x = radius * std::cos(phi), blend = 0.5 * (1 + vz);
  const double y = (1 - blend) * std::sqrt(std::max(0.0, 1 - x * x)) + blend * radius * std::sin(phi);
  const double z = std::sqrt(std::max(0.0, 1 - x * x - y * y));
  // The frame: v, (0, 1, 0) and their cross product (-vz, 0, vx).
  double hx = alpha * (-vz * y + vx * z), hy = alpha * x, hz = std::max(0.0, vx * y + vz * z);
  const double length = std::sqrt(hx * hx + hy * hy + hz * hz);
  hx /= length, hz /= length;
  const double cos_oh = sine * hx + cosine * hz, out = 2 * cos_oh * hz - cosine;
  const double alpha2 = alpha * alpha, g1 = 1 + lambda(alpha2, cosine);
  return {cos_oh, out > 0 ? g1 / (g1 + lambda(alpha2, out)) : 0};
}

/// Calls add(weight, node) for all nodes; the weights' sum is 1. Both halves of the disk do the same: one is
/// enough. Rings are dense at the rim, where the long tail of slopes is: the area outside of one is t^3, with
/// two Gauss nodes in each step of t.
template <class Add>
void for_visible_normals(double roughness, double mu, const Add& add) {
  constexpr int kSteps = 32, kSectors = 32;
  constexpr double kGauss = 0.28867513459481287;  // 1 / sqrt(12)
  const double alpha = roughness * roughness, sine = std::sqrt(1 - mu * mu);
  for (int i = 0; i < 2 * kSteps; ++i) {
    const double t = (i / 2 + 0.5 + (i % 2 == 0 ? -kGauss : kGauss)) / kSteps;
    const double weight = 3 * t * t / (2 * kSteps * kSectors);
    for (int j = 0; j < kSectors; ++j) {
      const double phi = M_PI * ((j + 0.5) / kSectors - 0.5);
      add(weight, visible_normal(alpha, sine, mu, std::sqrt(1 - t * t * t), phi));
    }
  }
}

double albedo_of(double roughness, double mu) {
  double sum = 0;
  for_visible_normals(roughness, mu, [&](double weight, const Node& node) { sum += weight * node.passes; });
  return sum;
}

double fresnel(double cosine, double eta) {
  const double g = std::sqrt(eta * eta - 1 + cosine * cosine);
  const double a = (g - cosine) / (g + cosine), b = (cosine * (g + cosine) - 1) / (cosine * (g - cosine) + 1);
  return 0.5 * a * a * (1 + b * b);
}

double at(int i, int count) {
  return std::clamp(static_cast<double>(i) / (count - 1), kLeast, 1.0);
}

}  // namespace

GgxEnergy::GgxEnergy()
    : albedo_(kFine * kFine), mean_albedo_(kFine), fresnel_share_(kCoarse * kCoarse * kCoarse) {
  parallel_for_each(0, kFine, [&](int x) {
    const double roughness = at(x, kFine);
    for (int y = 0; y < kFine; ++y)
      albedo_[y * kFine + x] = static_cast<float>(albedo_of(roughness, at(y, kFine)));
    constexpr int kCosines = 32;
    double sum = 0;
    for (int k = 0; k < kCosines; ++k) {
      const double mu = (k + 0.5) / kCosines;
      sum += 2 * mu * albedo_of(roughness, mu);
    }
    mean_albedo_[x] = static_cast<float>(sum / kCosines);
  });
  parallel_for_each(0, kCoarse * kCoarse, [&](int cell) {
    // z = 0 is an index of 1: no reflection, which is what is there already.
    double sums[kCoarse] = {}, eta[kCoarse], f0[kCoarse];
    for (int z = 1; z < kCoarse; ++z) {
      const double root = std::min(at(z, kCoarse), kMostZ);
      f0[z] = root * root * root * root;
      eta[z] = (1 + root * root) / (1 - root * root);
    }
    for_visible_normals(at(cell % kCoarse, kCoarse), at(cell / kCoarse, kCoarse),
                        [&](double weight, const Node& node) {
                          if (!(node.passes > 0)) return;
                          for (int z = 1; z < kCoarse; ++z) {
                            const double share = (fresnel(node.cos_oh, eta[z]) - f0[z]) / (1 - f0[z]);
                            sums[z] += weight * std::max(0.0, share);
                          }
                        });
    for (int z = 0; z < kCoarse; ++z)
      fresnel_share_[z * kCoarse * kCoarse + cell] = static_cast<float>(std::min(sums[z], 1.0));
  });
}

const GgxEnergy& ggx_energy() {
  static const GgxEnergy energy;
  return energy;
}

}  // namespace ohb::renderer
