// Errors at the edges: files and arguments. Programs print what() as one line and exit with the code.
#pragma once

#include <stdexcept>
#include <string>

namespace ohb {

/// Exit codes of every command (docs/commands).
enum ExitCode { kExitDone = 0, kExitDifference = 1, kExitBadInput = 2, kExitBug = 70, kExitTryAgain = 75 };

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

}  // namespace ohb
