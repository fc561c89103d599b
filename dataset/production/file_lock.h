// Locks that die with their process, however it ends. They hold on one machine and, over NFS, between
// machines (Linux turns flock into a lock of the server's).
#pragma once

#include <filesystem>

namespace ohb::production {

class FileLock {
 public:
  enum class Kind { kExclusive, kShared };

  /// Makes the file if need be and tries to lock it; `held` says whether that worked. Throws as
  /// write_file_atomically where the file cannot be made.
  FileLock(const std::filesystem::path& file, Kind kind);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

  bool held() const { return held_; }
  /// Waits until it is held, asking throw_if_interrupted meanwhile.
  void wait();
  /// From exclusive to shared, without a moment in which it is not held.
  void share();

 private:
  bool try_lock();

  std::filesystem::path file_;
  Kind kind_;
  int handle_ = -1;
  bool held_ = false;
};

}  // namespace ohb::production
