#include "dataset/model/lab_colour.h"

#include <cmath>

namespace ohb {

Vec3f linear_to_lab(Vec3f c) {
  const double white[3] = {0.95047, 1.0, 1.08883};
  const double xyz[3] = {0.4124564 * c.x + 0.3575761 * c.y + 0.1804375 * c.z,
                         0.2126729 * c.x + 0.7151522 * c.y + 0.0721750 * c.z,
                         0.0193339 * c.x + 0.1191920 * c.y + 0.9503041 * c.z};
  double f[3];
  for (int i = 0; i < 3; ++i) {
    const double t = xyz[i] / white[i], delta = 6.0 / 29;
    f[i] = t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0 / 29;
  }
  return {static_cast<float>(116 * f[1] - 16), static_cast<float>(500 * (f[0] - f[1])),
          static_cast<float>(200 * (f[1] - f[2]))};
}

}  // namespace ohb
