// Daylight in closed form: clear skies by Preetham, Shirley and Smits, "A Practical Analytic Model for
// Daylight" (SIGGRAPH 1999), overcast ones by the CIE. Photometric: radiance in kcd/m2, irradiance in klx, as
// linear Rec. 709 whose luminance is that number. Directions: y up.
#pragma once

#include "dataset/model/vec.h"

namespace ohb::environments {

/// Preetham's sky (appendix A.2: zenith and the distribution of Perez et al. 1993). Valid for turbidity 2 to
/// 10 and suns above the horizon; colours that it makes negative are cut to 0.
class ClearSky {
 public:
  ClearSky(Vec3f sun, float turbidity);
  /// 0 below the horizon.
  Vec3f radiance(Vec3f direction) const;

 private:
  struct Perez {
    double a, b, c, d, e;
    double operator()(double cos_theta, double gamma, double cos_gamma) const;
  };
  Vec3f sun_;
  Perez luminance_, x_, y_;
  double zenith_luminance_, zenith_x_, zenith_y_;  // over Perez's value at the zenith
};

/// The sun's irradiance on a plane that faces it, outside the air 128 klx of white: what Rayleigh scattering
/// and Angstrom's aerosol leave (Preetham et al., appendix A.1, at 610, 550 and 465 nm; ozone, mixed gases
/// and water are left out) along Kasten's relative air mass.
Vec3f sun_irradiance(float cos_theta, float turbidity);

/// The CIE's standard overcast sky (Moon and Spencer 1942): zenith x (1 + 2 cos theta) / 3, 0 below the
/// horizon; its irradiance on the ground is 7 pi / 9 of the zenith's radiance.
float overcast_share(Vec3f direction);

}  // namespace ohb::environments
