#include "learner/colour_profile.h"

#include <lcms2.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "dataset/model/error.h"
#include "dataset/model/oiio_compat.h"
#include "dataset/model/vec.h"

namespace ohb::learner {
namespace {

using Profile = std::unique_ptr<void, decltype(&cmsCloseProfile)>;
using Transform = std::unique_ptr<void, decltype(&cmsDeleteTransform)>;

/// Whether it leaves a grid of colours where they are, as far as 8 bits tell.
bool is_identity(const Transform& transform) {
  std::vector<Vec3f> colours;
  for (const float r : {0.0f, 0.25f, 0.5f, 0.75f, 1.0f})
    for (const float g : {0.0f, 0.5f, 1.0f})
      for (const float b : {0.0f, 0.5f, 1.0f}) colours.push_back({r, g, b});
  std::vector<Vec3f> turned(colours.size());
  cmsDoTransform(transform.get(), colours.data(), turned.data(),
                 static_cast<cmsUInt32Number>(colours.size()));
  for (size_t i = 0; i < colours.size(); ++i)
    for (int c = 0; c < 3; ++c)
      if (!(std::abs(turned[i][c] - colours[i][c]) < 1.0f / 512)) return false;
  return true;
}

}  // namespace

std::string colour_profile_of(const std::filesystem::path& file) {
  const auto input = OIIO::ImageInput::open(file.string());
  if (!input)
    throw InputError(file.string(), "", "cannot be opened: " + oiio_error(nullptr), "give a picture");
  const OIIO::ParamValue* profile = input->spec().find_attribute("ICCProfile");
  if (profile == nullptr || profile->type().basetype != OIIO::TypeDesc::UINT8) return "";
  return std::string(static_cast<const char*>(profile->data()), profile->type().size());
}

ProfileUse to_srgb(Image& picture, const std::string& profile) {
  if (profile.empty()) return ProfileUse::kNone;
  const Profile from(cmsOpenProfileFromMem(profile.data(), static_cast<cmsUInt32Number>(profile.size())),
                     cmsCloseProfile);
  if (!from) return ProfileUse::kUnreadable;
  if (cmsGetColorSpace(from.get()) != cmsSigRgbData || picture.channels < 3) return ProfileUse::kNone;
  const Profile srgb(cmsCreate_sRGBProfile(), cmsCloseProfile);
  const Transform transform(
      cmsCreateTransform(from.get(), TYPE_RGB_FLT, srgb.get(), TYPE_RGB_FLT, INTENT_RELATIVE_COLORIMETRIC,
                         cmsFLAGS_NOOPTIMIZE | cmsFLAGS_NOCACHE),
      cmsDeleteTransform);
  if (!transform) return ProfileUse::kUnreadable;
  if (is_identity(transform)) return ProfileUse::kIsSrgb;
  std::vector<Vec3f> row(static_cast<size_t>(picture.width_px));
  for (int y = 0; y < picture.height_px; ++y) {
    for (int x = 0; x < picture.width_px; ++x) std::copy_n(picture.pixel(x, y), 3, &row[x].x);
    cmsDoTransform(transform.get(), row.data(), row.data(), static_cast<cmsUInt32Number>(row.size()));
    for (int x = 0; x < picture.width_px; ++x)
      for (int c = 0; c < 3; ++c) picture.pixel(x, y)[c] = std::clamp(row[x][c], 0.0f, 1.0f);
  }
  return ProfileUse::kApplied;
}

}  // namespace ohb::learner
