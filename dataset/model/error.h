// Errors at the edges: files and arguments. Programs print what() as one line and exit with the code.
#pragma once

#include <stdexcept>
#include <string>

namespace ohb {

/// Exit codes of every command (docs/commands).
enum ExitCode {
  kExitDone = 0,
  kExitDifference = 1,  // a check found one
  kExitBadInput = 2,
  kExitUndecided = 3,  // validate: no difference was shown, but too few samples to exclude one
  kExitBug = 70,
  kExitTryAgain = 75
};

/// Bad input or usage: exit code 2. what() is one line: "file: place: what is wrong; mend".
/// `place` and `mend` may be empty.
class InputError : public std::runtime_error {
 public:
  InputError(const std::string& file, const std::string& place, const std::string& cause,
             const std::string& mend);
};

/// Nothing is wrong with the input, but it can't be done now (disk full, stopped): exit code 75.
class TryAgainError : public std::runtime_error {
 public:
  TryAgainError(const std::string& file, const std::string& cause, const std::string& mend);
};

/// Whether a library's message says that there was not enough memory: OpenImageIO and libtorch tell it by
/// words alone.
bool speaks_of_memory(const std::string& message);

}  // namespace ohb
