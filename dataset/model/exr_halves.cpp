#include "dataset/model/exr_halves.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>

#include <algorithm>

#include "dataset/model/halves.h"

namespace ohb {

bool read_half_rows(const std::filesystem::path& file, const std::vector<std::string>& channels,
                    Image& image) {
  constexpr int kRows = 64;  // whole blocks of any compression, and little enough for the cache
  Imf::InputFile input(file.c_str());
  for (const std::string& name : channels)
    if (!input.header().channels().findChannel(name)) return false;
  const auto& window = input.header().dataWindow();
  const size_t texel = channels.size() * sizeof(uint16_t), row = texel * static_cast<size_t>(image.width_px);
  std::vector<uint16_t> halves(kRows * row / sizeof(uint16_t));
  for (int y = 0; y < image.height_px; y += kRows) {
    const int first = window.min.y + y, last = std::min(first + kRows - 1, window.max.y);
    Imf::FrameBuffer buffer;
    for (size_t c = 0; c < channels.size(); ++c) {
      // OpenEXR wants the place of pixel (0, 0).
      const ptrdiff_t origin = static_cast<ptrdiff_t>(first) * static_cast<ptrdiff_t>(row) +
                               static_cast<ptrdiff_t>(window.min.x) * static_cast<ptrdiff_t>(texel);
      buffer.insert(channels[c],
                    Imf::Slice(Imf::HALF, reinterpret_cast<char*>(halves.data() + c) - origin, texel, row));
    }
    input.setFrameBuffer(buffer);
    input.readPixels(first, last);
    floats_of(halves.data(), static_cast<size_t>(last - first + 1) * row / sizeof(uint16_t),
              image.pixel(0, y));
  }
  return true;
}

}  // namespace ohb
