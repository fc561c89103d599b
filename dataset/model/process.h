// Runs another program and reads what it prints.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace ohb {

struct ProcessResult {
  int exit_code = 0;                    // 128 + signal if a signal ended it
  std::vector<std::string> last_lines;  // of its output, at most 40
};

/// Runs arguments[0] (found by PATH) without a shell, with stdin closed and stderr joined to stdout; calls
/// `on_line` for each line of output, and `on_wait`, if given, some ten times a second while there is none.
/// `environment` adds or replaces variables. The program is ended
/// with all that it started if a signal ends ours or `on_line` or `on_wait` throws (SIGTERM, half a second
/// later SIGKILL). Throws InputError if it cannot be started, TryAgainError if a signal stops us
/// (interrupt.h).
ProcessResult run_process(const std::vector<std::string>& arguments,
                          const std::vector<std::pair<std::string, std::string>>& environment,
                          const std::function<void(const std::string&)>& on_line,
                          const std::function<void()>& on_wait = nullptr);

}  // namespace ohb
