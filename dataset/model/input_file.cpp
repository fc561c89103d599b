#include "dataset/model/input_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "dataset/model/error.h"

namespace ohb {

void expect_input_file(const std::filesystem::path& file) {
  struct stat status {};
  const auto refuse = [&](const std::string& cause, const char* mend) {
    throw InputError(file.string(), "", cause, mend);
  };
  if (file.empty()) throw InputError("", "", "the name of a file to read is empty", "name the file");
  if (::stat(file.c_str(), &status) != 0) {
    if (errno == ENOENT || errno == ENOTDIR) refuse("no such file", "check the path");
    refuse(std::string("cannot be read: ") + std::strerror(errno), "check the path and its permissions");
  }
  if (S_ISDIR(status.st_mode)) refuse("is a folder, not a file", "name the file in it");
  if (!S_ISREG(status.st_mode))
    refuse(S_ISFIFO(status.st_mode) ? "is a pipe, not a file" : "is a device, not a file",
           "save its content as a file first");
  if (::access(file.c_str(), R_OK) != 0)
    refuse(std::string("cannot be read: ") + std::strerror(errno), "check its permissions");
}

}  // namespace ohb
