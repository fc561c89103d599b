#include "dataset/people/asset_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <cmath>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"

namespace ohb::people {
namespace fs = std::filesystem;
namespace {

constexpr size_t kMaxText_bytes = size_t{256} << 20;
constexpr const char* kMend = "take the file from MakeHuman's asset packs again";

std::string inflate_gzip(const std::string& packed, const fs::path& file) {
  z_stream stream{};
  constexpr int kGzip = 16 + MAX_WBITS;
  if (inflateInit2(&stream, kGzip) != Z_OK) throw std::bad_alloc();
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  std::string text;
  int state = Z_OK;
  while (state == Z_OK && text.size() <= kMaxText_bytes) {
    const size_t had = text.size();
    text.resize(had + (size_t{1} << 18));
    stream.next_out = reinterpret_cast<Bytef*>(text.data() + had);
    stream.avail_out = static_cast<uInt>(text.size() - had);
    state = inflate(&stream, Z_NO_FLUSH);
    text.resize(text.size() - stream.avail_out);
  }
  inflateEnd(&stream);
  if (text.size() > kMaxText_bytes)
    throw InputError(file.string(), "", "unpacks to more than 256 MiB", kMend);
  if (state != Z_STREAM_END) throw InputError(file.string(), "", "is not a whole gzip file", kMend);
  return text;
}

}  // namespace

std::string read_asset_text(const fs::path& file) {
  std::error_code error;
  const auto bytes = fs::file_size(file, error);
  if (!error && bytes > kMaxText_bytes)
    throw InputError(file.string(), "", "is larger than 256 MiB",
                     "check that it is one of MakeHuman's files");
  std::string text = read_file(file);
  return file.extension() == ".gz" ? inflate_gzip(text, file) : text;
}

bool AssetLines::next() {
  while (lines_.next()) {
    rest_ = lines_.line();
    if (!rest_.empty() && rest_.substr(0, 2) != "//") return true;
  }
  return false;
}

float AssetLines::number(const char* what) {
  const std::string_view text = word();
  float value = 0;
  if (!parse_float(text, value) || !std::isfinite(value))
    fail(text.empty() ? fmt::format("the {} is missing", what)
                      : fmt::format("the {} is '{}', not a number", what, text.substr(0, 40)));
  return value;
}

uint32_t AssetLines::index(const char* what, size_t count) {
  const std::string_view text = word();
  long long value = 0;
  if (!parse_integer(text, value))
    fail(text.empty() ? fmt::format("the {} is missing", what)
                      : fmt::format("the {} is '{}', not an index", what, text.substr(0, 40)));
  if (value < 0 || static_cast<unsigned long long>(value) >= count)
    fail(fmt::format("the {} is {}, and there are {}", what, value, count));
  return static_cast<uint32_t>(value);
}

void AssetLines::fail(const std::string& cause) const {
  throw InputError(file_.string(), lines_.place(), cause, kMend);
}

fs::path asset_path(const fs::path& assets, const fs::path& referrer, const std::string& name) {
  std::string slashes = name;
  for (char& c : slashes)
    if (c == '\\') c = '/';
  const fs::path file = (referrer.parent_path() / slashes).lexically_normal();
  const fs::path inside = file.lexically_relative(assets.lexically_normal());
  if (inside.empty() || *inside.begin() == "..")
    throw InputError(referrer.string(), "", "names '" + name + "', which lies outside the assets' folder",
                     "keep each file below the folder of the assets");
  std::error_code error;
  if (!fs::is_regular_file(file, error))
    throw InputError(referrer.string(), "", "names '" + name + "', which is not there", kMend);
  return file;
}

}  // namespace ohb::people
