#include "renderer/validation/report_pictures.h"

#include "renderer/validation/pictures.h"

namespace ohb::validation {

ReportScales report_scales(const Validation& v) {
  ReportScales scales;
  scales.exposure = exposure_for(v.cycles.mean, v.coverage);
  scales.difference = round_limit(relative_difference(v.ours.mean, v.cycles.mean, v.pixels.foreground),
                                  v.pixels.foreground, 0.01f);
  return scales;
}

Image all_z(const Validation& v) {
  Image z = v.inside_bins.z;
  for (size_t i = 0; i < v.pixels.band.size(); ++i)
    if (v.pixels.band[i]) z.values[i] = v.band_bins.z.values[i];
  return z;
}

}  // namespace ohb::validation
