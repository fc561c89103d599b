// What counts as subsurface scattering (docs/conventions.md, "subsurface").
#pragma once

namespace ohb {

/// A subsurface map below this says that light does not scatter: an estimate is never exactly 0 on cloth, and
/// a walk of some hundredths of a millimetre only adds noise, glow and dirt. blender_addon has the same
/// number (data/materials.json). The table's values are 0 and .08.
constexpr float kLeastScattering = 0.01f;

/// A value of a subsurface map as it is to be used: 0 where it says that there is no scattering.
constexpr float scattering_of(float sss) {
  return sss < kLeastScattering ? 0.0f : sss;
}

}  // namespace ohb
