// CIE L*a*b*: differences of colours as people see them.
#pragma once

#include "dataset/model/vec.h"

namespace ohb {

/// Linear Rec. 709 to CIE L*a*b* 1976, white D65 (CIE 15:2004, IEC 61966-2-1 matrix).
Vec3f linear_to_lab(Vec3f linear);

}  // namespace ohb
