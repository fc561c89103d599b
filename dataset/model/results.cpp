#include "dataset/model/results.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>

#include "dataset/model/error.h"

namespace ohb {

void flush_results() {
  errno = 0;
  std::cout.flush();
  const bool failed = std::fflush(stdout) != 0 || std::ferror(stdout) != 0 || !std::cout;
  if (!failed) return;
  const std::string reason = errno != 0 ? std::string(": ") + std::strerror(errno) : "";
  throw TryAgainError("standard output", "the results could not be written" + reason,
                      "free some space, or send them elsewhere, and run the command again");
}

}  // namespace ohb
