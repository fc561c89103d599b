#include "dataset/model/image.h"

#include <Imath/half.h>
#include <OpenImageIO/imageio.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <csignal>

#include "dataset/model/atomic_file.h"
#include "dataset/model/halves.h"
#include "tests/support/test_files.h"

namespace ohb {
namespace {

/// This process may write files of that size only, while this lives: the kernel refuses more, as a full disk.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    handler_ = ::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    ::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

TEST(Image, FullDiskIsNoticedWhereverInTheFileItStrikes) {
  const TemporaryFolder folder;
  Image image(64, 64, 3);
  for (size_t i = 0; i < image.values.size(); ++i)
    image.values[i] = static_cast<float>(i * 7919 % 1000) / 1000;
  const std::vector<ExrPart> one = {{"a", {"R", "G", "B"}, ExrPart::Type::kHalf, image}};
  const std::vector<ExrPart> two = {one[0], {"b", {"X", "Y", "Z"}, ExrPart::Type::kFloat, image}};
  const std::vector<std::pair<const char*, std::function<void(const std::filesystem::path&)>>> writers = {
      {"one.exr", [&](const auto& file) { write_exr(file, one, {}); }},
      {"two.exr",
       [&](const auto& file) {
         write_exr(file, two, {{"ohb:seed", "1"}});
       }},
      {"image.png", [&](const auto& file) { write_png(file, image); }},
      {"text.txt", [&](const auto& file) { write_file_atomically(file, std::string(5000, 'x')); }}};
  for (const auto& [name, write] : writers) {
    write(folder / "whole");
    const auto size = static_cast<rlim_t>(std::filesystem::file_size(folder / "whole"));
    for (rlim_t limit : {rlim_t{0}, rlim_t{1}, size / 4, size / 2, size - 200, size - 1}) {
      const FileSizeLimit full_disk(limit);
      EXPECT_THROW(write(folder / name), TryAgainError) << name << " at " << limit << " of " << size;
    }
    {
      const FileSizeLimit just_enough(size);
      EXPECT_NO_THROW(write(folder / name)) << name;
    }
    std::filesystem::remove(folder / name);
    std::filesystem::remove(folder / "whole");
    EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << name << " left something behind";
  }
}

/// 64 x 64 grey pixels in one strip, behind the directory, where OpenImageIO's own writer has them before it.
std::string small_tiff() {
  constexpr uint32_t kSide = 64, kFields = 9, kStrip = 8 + 2 + 12 * kFields + 4;
  const std::pair<uint16_t, uint32_t> fields[kFields] = {{256, kSide}, {257, kSide}, {258, 8},
                                                         {259, 1},     {262, 1},     {273, kStrip},
                                                         {277, 1},     {278, kSide}, {279, kSide * kSide}};
  std::string bytes("II*\0\10\0\0\0", 8);
  const auto put = [&](auto value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  put(uint16_t{kFields});
  for (const auto& [tag, value] : fields) {
    put(tag);
    put(uint16_t{4});  // LONG
    put(uint32_t{1});
    put(value);
  }
  put(uint32_t{0});
  return bytes + std::string(kSide * kSide, '\x7f');
}

void write_jpeg(const std::filesystem::path& file, const Image& image) {
  auto output = OIIO::ImageOutput::create(file.string());
  ASSERT_TRUE(output->open(file.string(), OIIO::ImageSpec(image.width_px, image.height_px, image.channels,
                                                          OIIO::TypeDesc::UINT8)));
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, image.values.data()));
  output->close();
}

/// A decoder that fills what is missing says so in words, not by failing.
TEST(Image, IsNeverMadeUpFromHalfAFile) {
  const TemporaryFolder folder;
  Image image(200, 160, 3);
  for (size_t i = 0; i < image.values.size(); ++i)
    image.values[i] = static_cast<float>(i * 7919 % 1000) / 1000;
  write_jpeg(folder / "whole.jpg", image);
  const std::string jpeg = read_file(folder / "whole.jpg"), end_of_image = "\xff\xd9";
  write_file_atomically(folder / "half.jpg", jpeg.substr(0, jpeg.size() / 2) + end_of_image);
  write_file_atomically(folder / "stray.jpg",
                        jpeg.substr(0, jpeg.size() - 2) + std::string(5, '\0') + end_of_image);
  const std::string tiff = small_tiff();
  write_file_atomically(folder / "whole.tif", tiff);
  write_file_atomically(folder / "half.tif", tiff.substr(0, tiff.size() - 32 * 32));
  for (const char* whole : {"whole.jpg", "stray.jpg", "whole.tif"})
    EXPECT_NO_THROW(read_image(folder / whole)) << whole;
  for (const char* damaged : {"half.jpg", "half.tif"})
    expect_message(input_error_of([&] { read_image(folder / damaged); }), {damaged, "cannot be read"});
}

/// The fast reader gives what OpenImageIO gives, for halves and floats, any number of rows and channels.
TEST(Image, AnExrsFirstPartIsReadAsItIs) {
  const TemporaryFolder folder;
  for (const ExrPart::Type type : {ExrPart::Type::kHalf, ExrPart::Type::kFloat})
    for (const int channels : {1, 3})
      for (const int height_px : {1, 63, 64, 200}) {
        ExrPart part;
        part.name = "map";
        part.channels =
            channels == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"};
        part.type = type;
        part.image = Image(37, height_px, channels);
        for (size_t i = 0; i < part.image.values.size(); ++i)
          part.image.values[i] = 0.001f * static_cast<float>(i % 977) - 0.3f;
        const auto file = folder / "map.exr";
        write_exr(file, {part}, {});
        const Image image = read_exr_image(file);
        ASSERT_EQ(image.height_px, height_px);
        ASSERT_EQ(image.channels, channels);
        EXPECT_EQ(image.values, read_exr(file).at(0).image.values);
      }
}

TEST(Image, AnExrsFirstPartMayBeginAnywhereInItsPicture) {
  const TemporaryFolder folder;
  const auto file = folder / "map.exr";
  OIIO::ImageSpec spec(5, 70, 3, OIIO::TypeDesc::HALF);
  spec.x = spec.full_x = 3, spec.y = spec.full_y = -40;
  std::vector<float> values(static_cast<size_t>(5 * 70 * 3));
  for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i % 512);
  const auto output = OIIO::ImageOutput::create(file.string());
  ASSERT_TRUE(output && output->open(file.string(), spec));
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, values.data()) && output->close());
  EXPECT_EQ(read_exr_image(file).values, values);
}

/// Eight at once against one at a time: every half, what lies between two of them, and what is beyond.
TEST(Halves, AreTheNearestOfEachValue) {
  std::vector<float> values;
  for (uint32_t bits = 0; bits < 0x10000; ++bits) {
    const float value = imath_half_to_float(static_cast<uint16_t>(bits));
    if (!std::isfinite(value)) continue;
    for (float factor : {1.0f, 1.0f + 1.0f / 2048, 1.0f + 1.0f / 4096, 0.9997f})
      values.push_back(value * factor);
  }
  for (float value : {1e-30f, -1e-30f, 1e6f, -1e6f, INFINITY, -INFINITY}) values.push_back(value);
  const std::vector<uint16_t> halves = halves_of(values.data(), values.size());
  for (size_t i = 0; i < values.size(); ++i)
    ASSERT_EQ(halves[i], imath_float_to_half(std::clamp(values[i], -kLargestHalf, kLargestHalf)))
        << values[i];
  const std::vector<float> nan(8, NAN);
  EXPECT_TRUE(std::isnan(imath_half_to_float(halves_of(nan.data(), nan.size())[0])));
}

}  // namespace
}  // namespace ohb
