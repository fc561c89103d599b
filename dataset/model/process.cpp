#include "dataset/model/process.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "dataset/model/error.h"

namespace ohb {
namespace {

constexpr size_t kKeptLines = 40;
constexpr int kNotStarted = 127;

/// Ends and reaps the child unless it was waited for.
class Child {
 public:
  explicit Child(pid_t id) : id_(id) {}
  ~Child() {
    if (id_ > 0) {
      kill(id_, SIGTERM);
      wait();
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  int wait() {
    int status = 0;
    while (waitpid(id_, &status, 0) < 0 && errno == EINTR) continue;
    id_ = 0;
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  }

 private:
  pid_t id_;
};

std::vector<char*> pointers(std::vector<std::string>& strings) {
  std::vector<char*> list;
  for (std::string& s : strings) list.push_back(s.data());
  list.push_back(nullptr);
  return list;
}

std::vector<std::string> child_environment(const std::vector<std::pair<std::string, std::string>>& added) {
  std::vector<std::string> result;
  for (char** variable = environ; *variable; ++variable) {
    const std::string text = *variable;
    bool replaced = false;
    for (const auto& [name, value] : added) replaced |= text.compare(0, name.size() + 1, name + "=") == 0;
    if (!replaced) result.push_back(text);
  }
  for (const auto& [name, value] : added) result.push_back(name + "=" + value);
  return result;
}

/// In the child: only calls that are safe after fork.
[[noreturn]] void become(int output, pid_t parent, char* const* arguments, char* const* environment) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(kNotStarted);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (nothing >= 0) dup2(nothing, STDIN_FILENO);
  execvpe(arguments[0], arguments, environment);
  _exit(kNotStarted);
}

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

}  // namespace

ProcessResult run_process(const std::vector<std::string>& arguments,
                          const std::vector<std::pair<std::string, std::string>>& environment,
                          const std::function<void(const std::string&)>& on_line) {
  std::vector<std::string> argument_copy = arguments, variables = child_environment(environment);
  const std::vector<char*> argument_list = pointers(argument_copy), variable_list = pointers(variables);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0)
    throw TryAgainError(arguments[0], std::string("cannot be started: ") + std::strerror(errno),
                        "run the command again");
  const pid_t parent = getpid(), id = fork();
  if (id == 0) become(ends[1], parent, argument_list.data(), variable_list.data());
  close(ends[1]);
  std::unique_ptr<std::FILE, FileCloser> output(fdopen(ends[0], "r"));
  if (id < 0)
    throw TryAgainError(arguments[0], std::string("cannot be started: ") + std::strerror(errno),
                        "run the command again");
  Child child(id);
  ProcessResult result;
  char* line = nullptr;
  size_t capacity = 0;
  const std::unique_ptr<char*, void (*)(char**)> free_line(&line, [](char** text) { std::free(*text); });
  for (ssize_t length; (length = getline(&line, &capacity, output.get())) > 0;) {
    std::string text(line, static_cast<size_t>(length));
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
    if (result.last_lines.size() == kKeptLines) result.last_lines.erase(result.last_lines.begin());
    result.last_lines.push_back(text);
    if (on_line) on_line(text);
  }
  result.exit_code = child.wait();
  if (result.exit_code == kNotStarted && result.last_lines.empty())
    throw InputError(arguments[0], "", "cannot be started", "check the path");
  return result;
}

}  // namespace ohb
