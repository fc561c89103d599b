#include "dataset/production/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>

#include "dataset/model/atomic_file.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/temporary.h"

namespace ohb::production {
namespace {

constexpr int kNap_us = 100000;

}  // namespace

FileLock::FileLock(const std::filesystem::path& file, Kind kind) : file_(file), kind_(kind) {
  make_folders(folder_of(file));
  handle_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (handle_ < 0) throw_write_error(file, errno);
  held_ = try_lock();
}

FileLock::~FileLock() {
  ::close(handle_);
}

bool FileLock::try_lock() {
  const int how = kind_ == Kind::kExclusive ? LOCK_EX : LOCK_SH;
  while (::flock(handle_, how | LOCK_NB) != 0) {
    if (errno == EINTR) continue;
    if (errno == EWOULDBLOCK) return false;
    throw_write_error(file_, errno);  // a file system without locks: two producers would not see each other
  }
  return true;
}

void FileLock::wait() {
  while (!held_ && !(held_ = try_lock())) {
    throw_if_interrupted();
    ::usleep(kNap_us);
  }
}

void FileLock::share() {
  kind_ = Kind::kShared;
  held_ = try_lock();
}

}  // namespace ohb::production
