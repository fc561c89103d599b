// Runs humanmaterial from outside.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <string>
#include <vector>

#include "dataset/model/atomic_file.h"
#include "tests/support/paths.h"
#include "tests/support/test_files.h"

namespace ohb {

struct Result {
  int code;  // exit code, or minus the signal
  std::string out, error;
};

/// A started program, its outputs in files of `folder`.
class Program {
 public:
  Program(const TemporaryFolder& folder, const std::vector<std::string>& arguments)
      : out_(folder / "stdout"), error_(folder / "stderr") {
    std::vector<std::string> all = {program_path("humanmaterial")};
    all.insert(all.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& a : all) argv.push_back(a.data());
    argv.push_back(nullptr);
    child_ = ::fork();
    if (child_ == 0) {
      ::dup2(::open(out_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), STDOUT_FILENO);
      ::dup2(::open(error_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), STDERR_FILENO);
      ::execv(argv[0], argv.data());
      ::_exit(127);
    }
  }
  void send(int signal) { ::kill(child_, signal); }
  Result wait() {
    int status = 0;
    ::waitpid(child_, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), read_file(out_), read_file(error_)};
  }

 private:
  std::filesystem::path out_, error_;
  pid_t child_ = -1;
};

inline Result run(const TemporaryFolder& folder, const std::vector<std::string>& arguments) {
  return Program(folder, arguments).wait();
}

}  // namespace ohb
