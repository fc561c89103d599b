#include "dataset/model/atomic_file.h"

#include <fcntl.h>
#include <openssl/evp.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <system_error>

#include "dataset/model/error.h"
#include "dataset/model/foreign_content.h"
#include "dataset/model/input_file.h"
#include "dataset/model/temporary.h"

namespace ohb {
namespace fs = std::filesystem;
namespace {

constexpr size_t kBlock = size_t{1} << 20;

/// Hands the file's bytes on, block by block.
void read_blocks(const fs::path& file, const std::function<void(const char*, size_t)>& take) {
  expect_input_file(file);
  std::ifstream stream(file, std::ios::binary);
  std::string block(kBlock, '\0');
  while (stream) {
    stream.read(block.data(), kBlock);
    if (stream.gcount() > 0) take(block.data(), static_cast<size_t>(stream.gcount()));
  }
  if (!stream.eof()) throw InputError(file.string(), "", "cannot be read", "check its permissions");
}

/// SHA-256, fed piece by piece.
class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), &EVP_MD_CTX_free) {
    if (EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1)
      throw std::logic_error("SHA-256 is missing from libcrypto");
  }
  void add(const char* bytes, size_t count) { EVP_DigestUpdate(context_.get(), bytes, count); }
  std::string hex() {
    static constexpr char kHex[] = "0123456789abcdef";
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned int length = 0;
    EVP_DigestFinal_ex(context_.get(), digest, &length);
    std::string text;
    for (unsigned int i = 0; i < length; ++i) {
      text += kHex[digest[i] >> 4];
      text += kHex[digest[i] & 15];
    }
    return text;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

}  // namespace

void write_file_atomically(const fs::path& given, const std::function<void(const fs::path&)>& write) {
  const fs::path file = followed(given);
  const fs::file_status there = fs::status(file);
  if (fs::is_directory(there))
    throw InputError(file.string(), "", "is a folder, a file should be written there",
                     "name a file or remove the folder");
  if (fs::exists(there) && !fs::is_regular_file(there))  // it would be gone, for root even /dev/null
    throw InputError(file.string(), "", "is a device or a pipe, a file should be written there",
                     "name a file");
  sweep_leftovers_once(folder_of(file));
  const LockedTemporary temporary(file, LockedTemporary::Kind::kFile);
  write(temporary.path());
  sync_path(temporary.path(), false);
  if (::rename(temporary.path().c_str(), file.c_str()) != 0) throw_write_error(file, errno);
  sync_path(folder_of(file), true);
}

void write_file_atomically(const fs::path& file, const std::string& content) {
  write_file_atomically(file, [&](const fs::path& temporary) {
    const int handle = ::open(temporary.c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC);
    if (handle < 0) throw_write_error(file, errno);
    size_t done = 0;
    while (done < content.size()) {
      const ssize_t count = ::write(handle, content.data() + done, content.size() - done);
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) {
        const int error = errno;
        ::close(handle);
        throw_write_error(file, error);
      }
      done += static_cast<size_t>(count);
    }
    if (::close(handle) != 0) throw_write_error(file, errno);
  });
}

void make_folders(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw_write_error(folder, error.value());
}

std::string read_file(const fs::path& file) {
  std::string content;
  std::error_code ignored;
  if (const uintmax_t size = fs::file_size(file, ignored); !ignored) content.reserve(size);
  read_blocks(file, [&](const char* bytes, size_t count) { content.append(bytes, count); });
  refuse_pointer(file, content);
  return content;
}

std::string sha256_of_file(const fs::path& file) {
  Sha256 hash;
  read_blocks(file, [&](const char* bytes, size_t count) { hash.add(bytes, count); });
  return hash.hex();
}

std::string sha256_of(const std::string& bytes) {
  Sha256 hash;
  hash.add(bytes.data(), bytes.size());
  return hash.hex();
}

}  // namespace ohb
