// Any photograph and its mask, made into what the networks were trained on.
#pragma once

#include <filesystem>
#include <optional>

#include "dataset/model/image.h"
#include "learner/torch.h"

namespace ohb::learner {

/// An upright picture in colour.
struct Photo {
  Image linear;  // 3, Rec. 709, [0, 1] unless the file held floats
  Image alpha;   // 1, the file's own, or empty
};

/// PNG, JPEG, TIFF (8 or 16 bits, in the colours of their ICC profile, else as sRGB) or EXR and HDR (taken as
/// linear), grey or colour, with alpha or not, turned upright by its EXIF orientation; CMYK comes as the
/// image library converts it. Throws InputError as read_image, and for smaller than 16 x 16 pixels, more than
/// 4 channels, NaN or infinite values.
Photo read_photo(const std::filesystem::path& file);

/// Whether the photo's own alpha cuts something out: it has one that is not opaque everywhere.
bool has_cutout(const Photo& photo);

/// Coverage of the person, of the photo's size: `mask_file` (its alpha if it has one that is not 1
/// everywhere, else its brightness), or else the photo's alpha. Throws InputError: neither is there, another
/// size, nothing covered, all covered, or the surroundings covered and the person not (inverted).
Image mask_of(const Photo& photo, const std::filesystem::path& photo_file,
              const std::optional<std::filesystem::path>& mask_file);

/// The square of the photo that the networks see; it may reach beyond the photo's edges.
struct Crop {
  double left_px = 0, top_px = 0, side_px = 0;
};

/// Around the pixels with mask > 0.5, centred, with a twentieth of the subject's longer side on each side of
/// it, as the samples' camera has it.
Crop crop_around(const Image& mask);

struct Foreground {
  torch::Tensor input;  // (1, 4, size, size), see network_input
  torch::Tensor mask;   // (1, 1, size, size)
};
/// Area-averaged (or bilinearly enlarged) in linear light, premultiplied; beyond the photo the mask is 0.
Foreground foreground_of(const Photo& photo, const Image& mask, const Crop& crop, int size_px);

}  // namespace ohb::learner
