#include "dataset/environments/sky.h"

#include <algorithm>
#include <cmath>

namespace ohb::environments {
namespace {

constexpr double kPiDouble = 3.14159265358979323846;

/// Zenith chromaticity: turbidity squared, turbidity, 1 times the matrix times powers of the sun's angle.
double zenith_chromaticity(const double (&m)[3][4], double turbidity, double theta) {
  double sum = 0;
  const double of_turbidity[3] = {turbidity * turbidity, turbidity, 1};
  for (int i = 0; i < 3; ++i)
    sum += of_turbidity[i] * (((m[i][0] * theta + m[i][1]) * theta + m[i][2]) * theta + m[i][3]);
  return sum;
}

Vec3f rgb_of(double luminance, double x, double y) {
  if (luminance <= 0 || y <= 1e-3) return {};
  const double cie_x = x / y * luminance, cie_z = (1 - x - y) / y * luminance;
  const auto positive = [](double v) { return static_cast<float>(std::max(0.0, v)); };
  return {positive(3.2406 * cie_x - 1.5372 * luminance - 0.4986 * cie_z),
          positive(-0.9689 * cie_x + 1.8758 * luminance + 0.0415 * cie_z),
          positive(0.0557 * cie_x - 0.2040 * luminance + 1.0570 * cie_z)};
}

}  // namespace

double ClearSky::Perez::operator()(double cos_theta, double gamma, double cos_gamma) const {
  return (1 + a * std::exp(b / std::max(cos_theta, 0.01))) *
         (1 + c * std::exp(d * gamma) + e * cos_gamma * cos_gamma);
}

ClearSky::ClearSky(Vec3f sun, float turbidity) : sun_(sun) {
  const double t = static_cast<double>(turbidity), cos_sun = std::clamp(static_cast<double>(sun.y), 0.0, 1.0);
  const double theta = std::acos(cos_sun);
  luminance_ = {0.1787 * t - 1.4630, -0.3554 * t + 0.4275, -0.0227 * t + 5.3251, 0.1206 * t - 2.5771,
                -0.0670 * t + 0.3703};
  x_ = {-0.0193 * t - 0.2592, -0.0665 * t + 0.0008, -0.0004 * t + 0.2125, -0.0641 * t - 0.8989,
        -0.0033 * t + 0.0452};
  y_ = {-0.0167 * t - 0.2608, -0.0950 * t + 0.0092, -0.0079 * t + 0.2102, -0.0441 * t - 1.6537,
        -0.0109 * t + 0.0529};
  constexpr double kX[3][4] = {{0.00166, -0.00375, 0.00209, 0},
                               {-0.02903, 0.06377, -0.03202, 0.00394},
                               {0.11693, -0.21196, 0.06052, 0.25886}};
  constexpr double kY[3][4] = {{0.00275, -0.00610, 0.00317, 0},
                               {-0.04214, 0.08970, -0.04153, 0.00516},
                               {0.15346, -0.26756, 0.06670, 0.26688}};
  const double chi = (4.0 / 9 - t / 120) * (kPiDouble - 2 * theta);
  const double zenith = (4.0453 * t - 4.9710) * std::tan(chi) - 0.2155 * t + 2.4192;
  zenith_luminance_ = std::max(zenith, 0.05) / luminance_(1, theta, cos_sun);
  zenith_x_ = zenith_chromaticity(kX, t, theta) / x_(1, theta, cos_sun);
  zenith_y_ = zenith_chromaticity(kY, t, theta) / y_(1, theta, cos_sun);
}

Vec3f ClearSky::radiance(Vec3f direction) const {
  if (direction.y <= 0) return {};
  const double cos_theta = static_cast<double>(direction.y);
  const double cos_gamma = std::clamp(static_cast<double>(dot(direction, sun_)), -1.0, 1.0);
  const double gamma = std::acos(cos_gamma);
  return rgb_of(zenith_luminance_ * luminance_(cos_theta, gamma, cos_gamma),
                zenith_x_ * x_(cos_theta, gamma, cos_gamma), zenith_y_ * y_(cos_theta, gamma, cos_gamma));
}

Vec3f sun_irradiance(float cos_theta, float turbidity) {
  if (cos_theta <= 0) return {};
  const double theta_deg = std::acos(std::min(1.0, static_cast<double>(cos_theta))) * 180 / kPiDouble;
  const double air_mass = 1 / (static_cast<double>(cos_theta) + 0.15 * std::pow(93.885 - theta_deg, -1.253));
  const double beta = 0.04608 * static_cast<double>(turbidity) - 0.04586;
  constexpr double kOutside_klx = 128, kWavelength_um[3] = {0.610, 0.550, 0.465};
  Vec3f irradiance;
  for (int c = 0; c < 3; ++c) {
    const double depth =
        0.008735 * std::pow(kWavelength_um[c], -4.08) + beta * std::pow(kWavelength_um[c], -1.3);
    irradiance[c] = static_cast<float>(kOutside_klx * std::exp(-air_mass * depth));
  }
  return irradiance;
}

float overcast_share(Vec3f direction) {
  return direction.y <= 0 ? 0 : (1 + 2 * direction.y) / 3;
}

}  // namespace ohb::environments
