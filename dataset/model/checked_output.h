// The file that image writers write to. OpenImageIO's own buffers lose what goes wrong when they are flushed
// at the end: on a full disk a small EXR would be cut off without a word.
#pragma once

#include <OpenImageIO/filesystem.h>
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <string>

namespace ohb {

class CheckedOutput : public OIIO::Filesystem::IOProxy {
 public:
  explicit CheckedOutput(const std::string& file) : IOProxy(file, Write) {
    handle_ = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (handle_ < 0) error_ = errno;
  }
  ~CheckedOutput() override { close(); }
  CheckedOutput(const CheckedOutput&) = delete;
  CheckedOutput& operator=(const CheckedOutput&) = delete;

  const char* proxytype() const override { return "file"; }
  size_t write(const void* bytes, size_t count) override {
    size_t done = 0;
    while (done < count && error_ == 0) {
      const ssize_t written = ::pwrite(handle_, static_cast<const char*>(bytes) + done, count - done, m_pos);
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) {
        error_ = errno;
        break;
      }
      done += static_cast<size_t>(written);
      m_pos += written;
    }
    return done;
  }
  void close() override {
    if (handle_ >= 0 && ::close(handle_) != 0 && error_ == 0) error_ = errno;
    handle_ = -1;
    m_mode = Closed;
  }

  /// errno of the first thing that went wrong; 0: all is written.
  int error() const { return error_; }

 private:
  int handle_ = -1, error_ = 0;
};

}  // namespace ohb
