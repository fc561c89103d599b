#include "dataset/model/atomic_file.h"

#include <fcntl.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "dataset/model/error.h"

namespace ohb {
namespace fs = std::filesystem;
namespace {

constexpr const char* kMarkerName = ".openhumanbrdf";

// The process and a counter keep two writers of one name apart.
std::string unique_suffix() {
  static std::atomic<unsigned> counter{0};
  return std::to_string(::getpid()) + "-" + std::to_string(counter++);
}

[[noreturn]] void throw_write_error(const fs::path& file, int error) {
  if (error == ENOSPC || error == EDQUOT || error == EFBIG)
    throw TryAgainError(file.string(), std::string("cannot be written: ") + std::strerror(error),
                        "free some space and run the command again");
  throw InputError(file.string(), "", std::string("cannot be written: ") + std::strerror(error),
                   "check that the folder exists and may be written to");
}

fs::path folder_of(const fs::path& file) {
  return file.parent_path().empty() ? fs::path(".") : file.parent_path();
}

// A rename is durable only when the data and then the folder's entry have reached the disk.
void sync_path(const fs::path& path, bool is_folder) {
  const int handle = ::open(path.c_str(), is_folder ? O_RDONLY | O_DIRECTORY : O_RDONLY);
  if (handle < 0) throw_write_error(path, errno);
  const int result = ::fsync(handle);
  const int error = errno;
  ::close(handle);
  if (result != 0 && error != EINVAL && error != EROFS) throw_write_error(path, error);
}

void rename_durably(const fs::path& from, const fs::path& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) throw_write_error(to, errno);
  sync_path(folder_of(to), true);
}

// Writers of libraries report a full disk in many ways; the free space says what it was.
void check_can_create(const fs::path& file) {
  const int handle = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (handle < 0) throw_write_error(file, errno);
  ::close(handle);
}

}  // namespace

void write_file_atomically(const fs::path& file, const std::function<void(const fs::path&)>& write) {
  if (fs::is_directory(file))
    throw InputError(file.string(), "", "is a folder, a file should be written there",
                     "name a file or remove the folder");
  const fs::path temporary = folder_of(file) / ("." + file.stem().string() + "." + unique_suffix() + ".tmp" +
                                                file.extension().string());
  try {
    check_can_create(temporary);
    write(temporary);
    sync_path(temporary, false);
    rename_durably(temporary, file);
  } catch (...) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw;
  }
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

AtomicFolder::AtomicFolder(const fs::path& folder) {
  // "out/" and "out" are one folder.
  folder_ = folder.has_filename() ? folder : folder.parent_path();
  if (folder_.empty()) throw InputError("", "-o", "names no folder", "give the folder to write");
  std::error_code error;
  if (fs::exists(folder_) && !fs::is_directory(folder_))
    throw InputError(folder_.string(), "", "is a file, a folder should be written there",
                     "choose another -o");
  if (fs::is_directory(folder_) && !fs::is_empty(folder_, error) && !fs::exists(folder_ / kMarkerName))
    throw InputError(folder_.string(), "", "exists and was not written by this program",
                     "choose another -o or remove it yourself");
  fs::create_directories(folder_of(folder_), error);
  if (error) throw_write_error(folder_of(folder_), error.value());
  temporary_ = folder_of(folder_) / ("." + folder_.filename().string() + "." + unique_suffix() + ".tmp");
  if (!fs::create_directory(temporary_, error)) throw_write_error(temporary_, error.value());
}

AtomicFolder::~AtomicFolder() {
  std::error_code ignored;
  if (!committed_) fs::remove_all(temporary_, ignored);
}

void AtomicFolder::commit() {
  write_file_atomically(temporary_ / kMarkerName, std::string("written by openhumanbrdf " OHB_VERSION "\n"));
  std::error_code error;
  // The old folder steps aside first: at no time is there neither an old nor a new one on disk.
  fs::path old;
  if (fs::exists(folder_)) {
    old = folder_of(folder_) / ("." + folder_.filename().string() + "." + unique_suffix() + ".old");
    if (::rename(folder_.c_str(), old.c_str()) != 0) throw_write_error(folder_, errno);
  }
  rename_durably(temporary_, folder_);
  committed_ = true;
  if (!old.empty()) fs::remove_all(old, error);
}

void make_folders(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw_write_error(folder, error.value());
}

std::string read_file(const fs::path& file) {
  if (!fs::exists(file)) throw InputError(file.string(), "", "no such file", "check the path");
  if (fs::is_directory(file))
    throw InputError(file.string(), "", "is a folder, not a file", "name the file in it");
  std::ifstream stream(file, std::ios::binary);
  std::string content;
  std::error_code error;
  constexpr size_t kBlock = size_t{1} << 20;
  const uintmax_t size = fs::file_size(file, error);
  if (!error) content.reserve(size + kBlock);
  while (stream) {
    const size_t before = content.size();
    content.resize(before + kBlock);
    stream.read(&content[before], kBlock);
    content.resize(before + static_cast<size_t>(stream.gcount()));
  }
  if (!stream.eof()) throw InputError(file.string(), "", "cannot be read", "check its permissions");
  return content;
}

std::string sha256_of_file(const fs::path& file) {
  const std::string content = read_file(file);
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int length = 0;
  if (EVP_Digest(content.data(), content.size(), digest, &length, EVP_sha256(), nullptr) != 1)
    throw std::logic_error("SHA-256 is missing from libcrypto");
  static constexpr char kHex[] = "0123456789abcdef";
  std::string text;
  for (unsigned int i = 0; i < length; ++i) {
    text += kHex[digest[i] >> 4];
    text += kHex[digest[i] & 15];
  }
  return text;
}

}  // namespace ohb
