// Images in memory, and the one place that reads and writes image files (OpenImageIO 2.4 to 3).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace ohb {

/// Interleaved float pixels, row 0 at the top.
struct Image {
  int width_px = 0, height_px = 0, channels = 0;
  std::vector<float> values;

  Image() = default;
  Image(int width, int height, int channel_count);  // all 0
  float* pixel(int x, int y) { return &values[(static_cast<size_t>(y) * width_px + x) * channels]; }
  const float* pixel(int x, int y) const {
    return &values[(static_cast<size_t>(y) * width_px + x) * channels];
  }
};

/// The same with 8 bits a value, as PNG stores them.
struct ByteImage {
  int width_px = 0, height_px = 0, channels = 0;
  std::vector<uint8_t> values;

  ByteImage() = default;
  ByteImage(int width, int height, int channel_count)
      : width_px(width),
        height_px(height),
        channels(channel_count),
        values(static_cast<size_t>(width) * height * channel_count) {}
};

/// How a file stored its values, as far as a reader must know.
struct ImageFileInfo {
  int width_px = 0, height_px = 0, channels = 0;
  int bits = 0;              // per channel: 8, 16, 32
  bool is_float = false;     // half or float
  bool has_alpha = false;    // the last channel is alpha
  int orientation = 1;       // EXIF: 1 is upright; the pixels are as stored, not turned
  bool says_linear = false;  // the file says that its values are linear: floats, and PNG with a gAMA of 1
};

/// Any PNG, JPEG, TIFF, EXR or HDR, values as stored: integers over their maximum (encoded values stay
/// encoded), floats as they are, alpha never premultiplied into the colour. An EXR's data window is placed in
/// its display window (0 where nothing is stored), a Radiance picture is turned by its resolution line. Of
/// several parts the first is read, whose channels the library puts in the order R, G, B, A.
/// Throws InputError for a file that is missing, empty, truncated or not an image, for deep and
/// luminance-chroma EXR, and where nothing lies in the display window.
Image read_image(const std::filesystem::path& file, ImageFileInfo* info = nullptr);
/// The same of an encoded image in memory; `name` stands for the file in messages.
Image read_image_bytes(const std::string& bytes, const std::string& name, ImageFileInfo* info = nullptr);

/// What read_image would say in `info`, without decoding. Throws as read_image; damage of the pixels is found
/// in PNG (checksums) and JPEG (missing end) only.
ImageFileInfo probe_image(const std::filesystem::path& file);
ImageFileInfo probe_image_bytes(const std::string& bytes, const std::string& name);

/// Threads that (de)compression of images may use; the bytes do not depend on it.
void limit_image_threads(int threads);

/// One part of a multi-part EXR.
struct ExrPart {
  enum class Type { kHalf, kFloat };
  std::string name;                   // unique in the file
  std::vector<std::string> channels;  // as many as the image has, for example {"R", "G", "B"}
  Type type = Type::kHalf;
  Image image;
  /// The coarser mip levels, each half the one before (rounded down, at least 1) down to one pixel; empty:
  /// none. A part with levels is tiled. read_exr reads the finest only.
  std::vector<Image> mips = {};
};

/// String attributes of the file's header, written to each part.
using ExrAttributes = std::vector<std::pair<std::string, std::string>>;

/// Writes a (multi-part) EXR, zip-compressed, with a fixed DateTime so that equal pixels give equal bytes.
/// Half values beyond 65504 are clamped. Atomic: written beside `file` and renamed.
/// Throws InputError if it cannot be written, TryAgainError if the disk is full.
void write_exr(const std::filesystem::path& file, const std::vector<ExrPart>& parts,
               const ExrAttributes& attributes);

/// The first part of an EXR: the values as they are, all channels. Throws InputError if it cannot be read.
Image read_exr_image(const std::filesystem::path& file);

/// All parts of an EXR, in file order, with the attributes of the first part.
std::vector<ExrPart> read_exr(const std::filesystem::path& file, ExrAttributes* attributes = nullptr);

/// 8-bit (or 16-bit) PNG of 1, 3 or 4 channels; values are clamped to [0,1], scaled and rounded, not
/// converted. Atomic. Throws as write_exr.
void write_png(const std::filesystem::path& file, const Image& image, int bits = 8);
/// Large flat areas: unfiltered and at zlib's lowest effort, in a third of the time.
void write_png(const std::filesystem::path& file, const ByteImage& image);

/// The part of that name. Throws InputError (naming `file`) if there is none.
const ExrPart& find_part(const std::vector<ExrPart>& parts, const std::string& name,
                         const std::filesystem::path& file);

/// Version of the image library, for --version.
std::string image_library_version();

}  // namespace ohb
