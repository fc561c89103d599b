#include "dataset/model/image.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <set>
#include <string_view>

#include "dataset/model/atomic_file.h"
#include "dataset/model/checked_output.h"
#include "dataset/model/error.h"
#include "dataset/model/exr_halves.h"
#include "dataset/model/foreign_content.h"
#include "dataset/model/halves.h"
#include "dataset/model/image_damage.h"
#include "dataset/model/image_place.h"
#include "dataset/model/input_file.h"
#include "dataset/model/large_memory.h"
#include "dataset/model/oiio_compat.h"

namespace ohb {
namespace fs = std::filesystem;
using namespace std::string_view_literals;
namespace {

constexpr const char* kFixedDateTime = "2000:01:01 00:00:00";
constexpr int kMaxEdge_px = 65536;

/// OpenImageIO may give several lines.
std::string first_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

[[noreturn]] void throw_unreadable(const fs::path& file, const std::string& reason) {
  if (speaks_of_memory(reason)) throw std::bad_alloc();
  throw InputError(file.string(), "", "cannot be read as an image (" + first_line(reason) + ")",
                   "export it again as PNG, JPEG, TIFF or EXR");
}

/// OpenImageIO's name of the format whose signature the file begins with, or null.
const char* format_of(std::string_view start) {
  const auto begins = [&](std::string_view magic) { return start.substr(0, magic.size()) == magic; };
  if (begins("\x89PNG\r\n\x1a\n")) return "png";
  if (begins("\xff\xd8\xff")) return "jpeg";
  for (const std::string_view magic : {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv})  // the last two: BigTIFF
    if (begins(magic)) return "tiff";
  if (begins("\x76\x2f\x31\x01")) return "openexr";
  if (begins("#?RADIANCE") || begins("#?RGBE")) return "hdr";
  return nullptr;
}

/// A header may claim any size; no format packs more than about this many values into a byte.
constexpr size_t kMaxValuesPerByte = 10000, kMaxValues = size_t{1} << 30;

void check_size(const OIIO::ImageSpec& spec, size_t byte_count, const fs::path& file) {
  const std::string size = std::to_string(spec.width) + " x " + std::to_string(spec.height) + " x " +
                           std::to_string(spec.nchannels);
  if (spec.width < 1 || spec.height < 1 || spec.width > kMaxEdge_px || spec.height > kMaxEdge_px ||
      spec.depth > 1 || spec.nchannels < 1 || spec.nchannels > 64)
    throw_unreadable(file, "size " + size);
  const size_t values = static_cast<size_t>(spec.width) * spec.height * spec.nchannels;
  if (values > kMaxValues || values / kMaxValuesPerByte > byte_count)
    throw_unreadable(file, "claims " + size + " values in " + std::to_string(byte_count) + " bytes");
  if (spec.deep)
    throw InputError(file.string(), "", "is a deep EXR: many samples a pixel", "flatten it (exr_flatten)");
}

/// Of the formats that keep a part of a picture only OpenEXR's windows, and TIFF's where RenderMan's tags
/// state the whole, are about pixels: positions in PNG and TIFF are those of a page.
PixelWindow window_of(const OIIO::ImageSpec& spec, std::string_view format, const fs::path& file) {
  const bool is_part =
      format == "openexr" ||
      (format == "tiff" && (spec.full_width != spec.width || spec.full_height != spec.height));
  if (!is_part) return {0, 0, spec.width, spec.height};
  const PixelWindow window{spec.x - spec.full_x, spec.y - spec.full_y, spec.full_width, spec.full_height};
  const std::string size = std::to_string(window.width_px) + " x " + std::to_string(window.height_px);
  // A huge window around little must not ask for the memory of a huge picture.
  constexpr long long kLargeWindow_px = 1 << 24, kLargestRatio = 1000;
  const long long pixels = 1LL * window.width_px * window.height_px, stored = 1LL * spec.width * spec.height;
  if (window.width_px < 1 || window.height_px < 1 || window.width_px > kMaxEdge_px ||
      window.height_px > kMaxEdge_px || static_cast<size_t>(pixels) * spec.nchannels > kMaxValues ||
      (pixels > kLargeWindow_px && pixels / kLargestRatio > stored))
    throw_unreadable(file, "its display window is " + size + ", its data " + std::to_string(spec.width) +
                               " x " + std::to_string(spec.height));
  const long long x = window.x_px, y = window.y_px;
  if (x >= window.width_px || y >= window.height_px || x + spec.width <= 0 || y + spec.height <= 0)
    throw InputError(file.string(), "",
                     "its data window lies outside its display window of " + size + ": nothing would be seen",
                     "export it again without a crop");
  return window;
}

/// Before the decoder sees it: libpng prints to stderr and libjpeg fills what is missing.
void check_complete(const fs::path& file, std::string_view format, std::string_view bytes) {
  const std::string damage = format == "png" ? png_damage(bytes) : jpeg_damage(bytes);
  if (!damage.empty()) throw InputError(file.string(), "", "is " + damage, "copy or export it again");
}

/// An image that is open for reading, from a file or from memory.
struct OpenImage {
  std::unique_ptr<OIIO::Filesystem::IOMemReader> memory;  // must outlive `input`
  std::unique_ptr<OIIO::ImageInput> input;
  fs::path file;
  size_t byte_count = 0;
  int hdr_orientation = 1;  // of a Radiance picture: as HdrLayout

  std::string_view format() const { return input->format_name(); }
  PixelWindow window() const { return window_of(input->spec(), format(), file); }
};

/// The library's word for it differs between versions; what it makes of the lengths is checked here.
int checked_hdr_orientation(const OIIO::ImageSpec& spec, std::string_view start, const fs::path& file) {
  const HdrLayout layout = hdr_layout(start);
  if (layout.is_xyz)
    throw InputError(file.string(), "", "holds XYZ colours (32-bit_rle_xyze)",
                     "convert it to RGB (ra_xyze -r), or export it as EXR");
  if (layout.orientation == 0 || layout.scanlines != spec.height || layout.scanline_pixels != spec.width)
    throw InputError(file.string(), "", "its resolution line cannot be understood",
                     "export it with -Y height +X width, or as EXR");
  return layout.orientation;
}

/// `bytes`: the whole image, or its start if it is a file.
void open_input(OpenImage& image, std::string_view bytes) {
  if (image.byte_count == 0)
    throw InputError(image.file.string(), "", "is empty (0 bytes)", "copy or export it again");
  const char* format = format_of(bytes);
  if (!format) {
    refuse_foreign_content(image.file, bytes);
    throw InputError(image.file.string(), "", "is no PNG, JPEG, TIFF, EXR or HDR image",
                     "export it as one of these");
  }
  OIIO::ImageSpec config, spec;
  config["oiio:UnassociatedAlpha"] = 1;
  if (std::string_view(format) == "png" || std::string_view(format) == "jpeg")
    check_complete(image.file, format, image.memory ? bytes : read_file(image.file));
  image.input = OIIO::ImageInput::create(format);
  if (!image.input) throw_unreadable(image.file, oiio_error(nullptr));
  if (image.memory) image.input->set_ioproxy(image.memory.get());
  if (!image.input->open(image.file.string(), spec, config))
    throw_unreadable(image.file, oiio_error(image.input.get()));
  check_size(image.input->spec(), image.byte_count, image.file);
  if (std::string_view(format) == "hdr")
    image.hdr_orientation = checked_hdr_orientation(image.input->spec(), bytes, image.file);
}

OpenImage open_image(const fs::path& file) {
  expect_input_file(file);
  std::ifstream stream(file, std::ios::binary);
  char start[4096] = {};  // enough for the header of a Radiance picture
  stream.read(start, sizeof start);
  OpenImage image;
  image.file = file;
  image.byte_count = fs::file_size(file);
  open_input(image, std::string_view(start, static_cast<size_t>(stream.gcount())));
  return image;
}

OpenImage open_image_bytes(const std::string& bytes, const std::string& name) {
  OpenImage image;
  image.file = name;
  image.byte_count = bytes.size();
  image.memory = std::make_unique<OIIO::Filesystem::IOMemReader>(bytes.data(), bytes.size());
  open_input(image, bytes);
  return image;
}

ImageFileInfo info_of(const OpenImage& open) {
  const OIIO::ImageSpec& spec = open.input->spec();
  const PixelWindow window = open.window();
  ImageFileInfo info;
  info.width_px = open.hdr_orientation >= 5 ? window.height_px : window.width_px;
  info.height_px = open.hdr_orientation >= 5 ? window.width_px : window.height_px;
  info.channels = spec.nchannels;
  info.bits = spec.get_int_attribute("oiio:BitsPerSample", static_cast<int>(spec.format.size()) * 8);
  info.is_float = spec.format.is_floating_point();
  info.has_alpha = spec.alpha_channel >= 0 && spec.alpha_channel == spec.nchannels - 1;
  // Turned already where the format, and no camera, says so.
  info.orientation = open.format() == "hdr" ? 1 : spec.get_int_attribute("Orientation", 1);
  info.says_linear = spec.get_string_attribute("oiio:ColorSpace") == "Linear";
  return info;
}

/// The sub-image that `open` stands at, in its display window.
Image read_part(const OpenImage& open, int subimage) {
  const OIIO::ImageSpec spec = open.input->spec();
  const PixelWindow window = open.window();
  Image image(spec.width, spec.height, spec.nchannels);
  const bool is_read = read_subimage(*open.input, subimage, spec.nchannels, image.values.data());
  const std::string words = oiio_error(open.input.get());
  if (!is_read || speaks_of_damage(words)) throw_unreadable(open.file, words);
  return upright(placed(std::move(image), window), open.hdr_orientation);
}

/// Whether read_half_rows() can read what is open.
bool holds_half_rows(const OpenImage& open, const OIIO::ImageSpec& spec) {
  return open.format() == "openexr" && !open.memory && spec.format == OIIO::TypeDesc::HALF &&
         spec.channelformats.empty() && spec.tile_width == 0 &&
         spec.get_int_attribute("oiio:subimages", 1) == 1;
}

Image read_first_part(const OpenImage& open, ImageFileInfo* info) {
  if (info) *info = info_of(open);
  return read_part(open, 0);
}

/// Halves are made here, some rows at a time: OpenImageIO takes one thread and several times as long.
bool write_values(OIIO::ImageOutput& output, const Image& image, ExrPart::Type type) {
  if (type == ExrPart::Type::kFloat) return output.write_image(OIIO::TypeDesc::FLOAT, image.values.data());
  constexpr int kRows = 512;  // whole tiles, and whole blocks of any compression
  for (int y = 0; y < image.height_px; y += kRows) {
    const int end = std::min(y + kRows, image.height_px);
    const size_t count = static_cast<size_t>(end - y) * image.width_px * image.channels;
    const std::vector<uint16_t> halves = halves_of(image.pixel(0, y), count);
    const bool is_done =
        output.spec().tile_width > 0
            ? output.write_tiles(0, image.width_px, y, end, 0, 1, OIIO::TypeDesc::HALF, halves.data())
            : output.write_scanlines(y, end, 0, OIIO::TypeDesc::HALF, halves.data());
    if (!is_done) return false;
  }
  return true;
}

OIIO::ImageSpec spec_of(const ExrPart& part, const ExrAttributes& attributes) {
  const bool half = part.type == ExrPart::Type::kHalf;
  OIIO::ImageSpec spec(part.image.width_px, part.image.height_px, part.image.channels,
                       half ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT);
  spec.channelnames = part.channels;
  spec.alpha_channel = -1;
  spec.attribute("compression", "zip");
  spec.attribute("DateTime", kFixedDateTime);
  spec.attribute("Software", "openhumanbrdf " OHB_VERSION);
  spec.attribute("oiio:subimagename", part.name);
  for (const auto& [name, value] : attributes) spec.attribute(name, value);
  if (part.mips.empty()) return spec;
  constexpr int kTile_px = 64;
  spec.tile_width = spec.tile_height = kTile_px;
  spec.attribute("textureformat", "Plain Texture");  // OpenImageIO's word for an EXR with mip levels
  spec.attribute("openexr:levelmode", 1);            // MIPMAP_LEVELS
  spec.attribute("openexr:roundingmode", 0);         // ROUND_DOWN
  return spec;
}

void check_written(bool done, OIIO::ImageOutput& output, const CheckedOutput& bytes, const fs::path& file) {
  if (done && bytes.error() == 0) return;
  const std::string reason = bytes.error() ? std::strerror(bytes.error()) : output.geterror();
  throw TryAgainError(file.string(), "cannot be written: " + reason,
                      "check the disk, free some space and run the command again");
}

[[noreturn]] void throw_no_writer(const fs::path& file, const std::string& format) {
  throw TryAgainError(file.string(), "cannot be written: OpenImageIO gives no " + format + " writer",
                      "free some memory and run the command again, or install OpenImageIO with it");
}

void write_png(const fs::path& file, OIIO::ImageSpec spec, const OIIO::TypeDesc& type, const void* values) {
  // The values are written as they are; OpenImageIO would otherwise un-premultiply them.
  spec.attribute("oiio:UnassociatedAlpha", 1);
  spec.attribute("DateTime", kFixedDateTime);
  // Encoded in memory first: libpng leaks when its output fails, and the encoded file is small.
  OIIO::Filesystem::IOVecOutput bytes;
  auto output = OIIO::ImageOutput::create("png");
  if (!output) throw_no_writer(file, "PNG");
  output->set_ioproxy(&bytes);
  if (!output->open(file.string(), spec) || !output->write_image(type, values) || !output->close())
    throw TryAgainError(file.string(), "cannot be encoded: " + output->geterror(),
                        "free some memory and run it again");
  write_file_atomically(file, std::string(bytes.buffer().begin(), bytes.buffer().end()));
}

}  // namespace

Image::Image(int width, int height, int channel_count)
    : width_px(width), height_px(height), channels(channel_count) {
  const size_t count = static_cast<size_t>(width) * height * channel_count;
  values.reserve(count);
  prefer_large_pages(values.data(), count * sizeof(float));
  values.resize(count);
}

Image read_image(const fs::path& file, ImageFileInfo* info) {
  return read_first_part(open_image(file), info);
}

Image read_image_bytes(const std::string& bytes, const std::string& name, ImageFileInfo* info) {
  return read_first_part(open_image_bytes(bytes, name), info);
}

ImageFileInfo probe_image(const fs::path& file) {
  return info_of(open_image(file));
}

ImageFileInfo probe_image_bytes(const std::string& bytes, const std::string& name) {
  return info_of(open_image_bytes(bytes, name));
}

void limit_image_threads(int threads) {
  OIIO::attribute("threads", threads);
  OIIO::attribute("exr_threads", threads);
}

void write_exr(const fs::path& file, const std::vector<ExrPart>& parts, const ExrAttributes& attributes) {
  if (parts.empty()) throw std::logic_error("write_exr: no part");
  std::vector<OIIO::ImageSpec> specs;
  specs.reserve(parts.size());
  for (const ExrPart& part : parts) specs.push_back(spec_of(part, attributes));
  write_file_atomically(file, [&](const fs::path& temporary) {
    auto output = OIIO::ImageOutput::create("exr");
    if (!output) throw_no_writer(file, "EXR");
    const std::string name = temporary.string();
    CheckedOutput bytes(name);
    output->set_ioproxy(&bytes);
    check_written(parts.size() == 1 ? output->open(name, specs[0])
                                    : output->open(name, static_cast<int>(specs.size()), specs.data()),
                  *output, bytes, file);
    for (size_t i = 0; i < parts.size(); ++i) {
      if (i > 0)
        check_written(output->open(name, specs[i], OIIO::ImageOutput::AppendSubimage), *output, bytes, file);
      check_written(write_values(*output, parts[i].image, parts[i].type), *output, bytes, file);
      for (const Image& mip : parts[i].mips) {
        specs[i].width = specs[i].full_width = mip.width_px;
        specs[i].height = specs[i].full_height = mip.height_px;
        check_written(output->open(name, specs[i], OIIO::ImageOutput::AppendMIPLevel) &&
                          write_values(*output, mip, parts[i].type),
                      *output, bytes, file);
      }
    }
    const bool is_closed = output->close();
    bytes.close();
    check_written(is_closed, *output, bytes, file);
  });
}

Image read_exr_image(const fs::path& file) {
  const OpenImage open = open_image(file);
  const OIIO::ImageSpec spec = open.input->spec();
  if (holds_half_rows(open, spec)) {
    Image image(spec.width, spec.height, spec.nchannels);
    try {
      if (read_half_rows(file, spec.channelnames, image)) return placed(std::move(image), open.window());
    } catch (const std::exception& error) {
      throw_unreadable(file, error.what());
    }
  }
  return read_part(open, 0);
}

std::vector<ExrPart> read_exr(const fs::path& file, ExrAttributes* attributes) {
  const OpenImage open = open_image(file);
  OIIO::ImageInput* input = open.input.get();
  std::vector<ExrPart> parts;
  for (int subimage = 0; input->seek_subimage(subimage, 0); ++subimage) {
    const OIIO::ImageSpec spec = input->spec();
    check_size(spec, open.byte_count, file);
    ExrPart part;
    part.name = spec.get_string_attribute("oiio:subimagename");
    part.channels = spec.channelnames;
    part.type = spec.format == OIIO::TypeDesc::HALF ? ExrPart::Type::kHalf : ExrPart::Type::kFloat;
    part.image = read_part(open, subimage);
    if (subimage == 0 && attributes)
      for (const OIIO::ParamValue& value : spec.extra_attribs)
        if (value.type() == OIIO::TypeDesc::STRING)
          attributes->emplace_back(value.name().string(), value.get_string());
    parts.push_back(std::move(part));
  }
  return parts;
}

void write_png(const fs::path& file, const Image& image, int bits) {
  const OIIO::TypeDesc type = bits == 16 ? OIIO::TypeDesc::UINT16 : OIIO::TypeDesc::UINT8;
  std::vector<float> values = image.values;
  for (float& value : values) value = std::isfinite(value) ? std::clamp(value, 0.0f, 1.0f) : 0.0f;
  write_png(file, OIIO::ImageSpec(image.width_px, image.height_px, image.channels, type),
            OIIO::TypeDesc::FLOAT, values.data());
}

void write_png(const fs::path& file, const ByteImage& image) {
  OIIO::ImageSpec spec(image.width_px, image.height_px, image.channels, OIIO::TypeDesc::UINT8);
  constexpr int kPngFilterNone = 8;  // libpng's PNG_FILTER_NONE
  spec.attribute("png:compressionLevel", 1);
  spec.attribute("png:filter", kPngFilterNone);
  write_png(file, spec, OIIO::TypeDesc::UINT8, image.values.data());
}

const ExrPart& find_part(const std::vector<ExrPart>& parts, const std::string& name, const fs::path& file) {
  for (const ExrPart& part : parts)
    if (part.name == name) return part;
  throw InputError(file.string(), "part '" + name + "'", "is missing",
                   "write the file again with this version");
}

std::string image_library_version() {
  return oiio_version();
}

}  // namespace ohb
