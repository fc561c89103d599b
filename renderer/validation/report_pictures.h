// What the pictures and their legends share.
#pragma once

#include "renderer/validation/validate.h"

namespace ohb::validation {

struct ReportScales {
  float exposure = 1;
  float difference = 0.01f;  // relative difference at the ends of the colour scale
  float z = 4;
};
ReportScales report_scales(const Validation& validation);

/// Z of the bins inside and of those of the outline, in one image of 1 channel.
Image all_z(const Validation& validation);

}  // namespace ohb::validation
