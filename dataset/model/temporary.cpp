#include "dataset/model/temporary.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <regex>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "dataset/model/error.h"

namespace ohb {
namespace fs = std::filesystem;
namespace {

constexpr size_t kLongestName = 255;
constexpr int kAttempts = 1000, kMostLinks = 40;

/// `.<stem>.<process>-<n><end>`; a stem that is too long for that is cut.
fs::path temporary_name(const fs::path& target, const std::string& stem, const std::string& end) {
  static std::atomic<unsigned> counter{0};
  const std::string rest = "." + std::to_string(::getpid()) + "-" + std::to_string(counter++) + end;
  const size_t room = kLongestName - std::min(kLongestName, rest.size() + 1);
  return folder_of(target) / ("." + stem.substr(0, room) + rest);
}

bool is_same(int handle, const fs::path& path) {
  struct stat held {
  }, named{};
  return ::fstat(handle, &held) == 0 && ::lstat(path.c_str(), &named) == 0 && held.st_dev == named.st_dev &&
         held.st_ino == named.st_ino;
}

int open_new(const fs::path& path, LockedTemporary::Kind kind) {
  if (kind == LockedTemporary::Kind::kFile)
    return ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (::mkdir(path.c_str(), 0777) != 0) return -1;
  const int handle = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (handle >= 0) return handle;
  const int error = errno;
  ::rmdir(path.c_str());                     // a umask may take its owner's rights away
  errno = error == ENOENT ? EEXIST : error;  // swept before it was locked: another name
  return -1;
}

/// A lock on what is at `path`, unless somebody else holds it or there is none to be had. -1: none.
int lock_of(const fs::path& path) {
  const int handle = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (handle < 0) return -1;
  if (::flock(handle, LOCK_EX | LOCK_NB) == 0 && is_same(handle, path)) return handle;
  ::close(handle);
  return -1;
}

/// The name that stepped aside, if `name` is one of replace_in_two_steps; "" for other temporaries.
bool is_leftover_name(const std::string& name, std::string& aside_from) {
  static const std::regex pattern(R"(\.([^/]*)\.[0-9]+-[0-9]+\.(tmp|old)(\.[^./]*)?)");
  std::smatch parts;
  if (!std::regex_match(name, parts, pattern)) return false;
  aside_from = parts[2] == "old" && !parts[3].matched ? parts[1].str() : "";
  return true;
}

void sweep(const fs::path& folder) {
  std::error_code ignored;
  std::vector<std::pair<fs::path, std::string>> found;
  for (fs::directory_iterator entry(folder, ignored), end; !ignored && entry != end;
       entry.increment(ignored)) {
    std::string aside_from;
    if (is_leftover_name(entry->path().filename().string(), aside_from))
      found.emplace_back(entry->path(), aside_from);
  }
  for (const auto& [path, aside_from] : found) {
    const int lock = lock_of(path);
    if (lock < 0) continue;
    const fs::path home = folder / aside_from;
    if (!aside_from.empty() && !fs::exists(fs::symlink_status(home, ignored)))
      fs::rename(path, home, ignored);
    else
      fs::remove_all(path, ignored);
    ::close(lock);
  }
}

}  // namespace

fs::path folder_of(const fs::path& path) {
  return path.parent_path().empty() ? fs::path(".") : path.parent_path();
}

fs::path followed(const fs::path& path) {
  fs::path now = path;
  std::error_code ignored;
  for (int i = 0; i < kMostLinks && fs::is_symlink(fs::symlink_status(now, ignored)); ++i) {
    const fs::path to = fs::read_symlink(now, ignored);
    if (to.empty()) return now;
    now = (to.is_absolute() ? to : folder_of(now) / to).lexically_normal();
    if (!now.has_filename()) now = now.parent_path();
  }
  return now;
}

void throw_write_error(const fs::path& file, int error) {
  const std::string cause = std::string("cannot be written: ") + std::strerror(error);
  if (error == ENOSPC || error == EDQUOT || error == EFBIG)
    throw TryAgainError(file.string(), cause, "free some space and run the command again");
  if (error == EBUSY) throw InputError(file.string(), "", cause, "name a folder inside of it");
  throw InputError(file.string(), "", cause, "check that the folder exists and may be written to");
}

void sync_path(const fs::path& path, bool is_folder) {
  const int handle = ::open(path.c_str(), (is_folder ? O_RDONLY | O_DIRECTORY : O_RDONLY) | O_CLOEXEC);
  if (handle < 0) throw_write_error(path, errno);
  const int result = ::fsync(handle);
  const int error = errno;
  ::close(handle);
  if (result != 0 && error != EINVAL && error != EROFS) throw_write_error(path, error);
}

LockedTemporary::LockedTemporary(const fs::path& target, Kind kind) {
  const bool is_file = kind == Kind::kFile;
  const std::string stem = (is_file ? target.stem() : target.filename()).string();
  const std::string end = ".tmp" + (is_file ? target.extension().string() : std::string());
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    path_ = temporary_name(target, stem, end);
    unfinished_.emplace(path_);
    handle_ = open_new(path_, kind);
    if (handle_ < 0 && errno == EEXIST) continue;
    if (handle_ < 0) throw_write_error(target, errno);
    // Where there are no locks nobody sweeps either. One that is being swept was not locked in time.
    if ((::flock(handle_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) && is_same(handle_, path_)) return;
    ::close(handle_);
  }
  throw TryAgainError(target.string(), "no temporary name beside it is free", "run the command again");
}

LockedTemporary::~LockedTemporary() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  ::close(handle_);
}

void sweep_leftovers(const fs::path& folder) noexcept {
  try {
    sweep(folder);
  } catch (const std::exception&) {
    // Tidying up is no reason to fail.
  }
}

void sweep_leftovers_once(const fs::path& folder) noexcept {
  static std::mutex mutex;
  static std::set<std::pair<dev_t, ino_t>> swept;
  try {
    struct stat status {};
    if (::stat(folder.c_str(), &status) != 0) return;
    const std::lock_guard<std::mutex> lock(mutex);
    if (swept.emplace(status.st_dev, status.st_ino).second) sweep(folder);
  } catch (const std::exception&) {
    // As above.
  }
}

void replace_folder(const fs::path& fresh, const fs::path& old) {
  // Not while `fresh` is being removed because a signal ends us.
  hold_off_ending([&] {
    if (::renameat2(AT_FDCWD, fresh.c_str(), AT_FDCWD, old.c_str(), RENAME_EXCHANGE) == 0) return;
    if (errno != EINVAL && errno != ENOSYS && errno != EXDEV) throw_write_error(old, errno);
    replace_in_two_steps(fresh, old);
  });
  sync_path(folder_of(old), true);
}

void replace_in_two_steps(const fs::path& fresh, const fs::path& old) {
  const fs::path aside = temporary_name(old, old.filename().string(), ".old");
  const int lock = lock_of(old);
  const auto fail = [&]() {
    const int error = errno;
    if (lock >= 0) ::close(lock);
    throw_write_error(old, error);
  };
  if (::rename(old.c_str(), aside.c_str()) != 0) fail();
  if (::rename(fresh.c_str(), old.c_str()) != 0) {
    const int error = errno;
    ::rename(aside.c_str(), old.c_str());
    errno = error;
    fail();
  }
  std::error_code ignored;
  fs::remove_all(aside, ignored);
  if (lock >= 0) ::close(lock);
}

}  // namespace ohb
