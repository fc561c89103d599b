#include "dataset/model/process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>

#include "dataset/model/error.h"
#include "dataset/model/interrupt.h"

namespace ohb {
namespace {

constexpr size_t kKeptLines = 40;
constexpr int kNotStarted = 127;
constexpr int kWake_ms = 100, kPatience_ms = 500, kNap_ms = 10;

/// Ends the child with its group and reaps it, unless it was waited for.
class Child {
 public:
  explicit Child(pid_t id) : id_(id), group_(id) {}
  ~Child() {
    if (id_ <= 0) return;
    kill(-id_, SIGTERM);
    // Gone in milliseconds as a rule; who does not listen is not asked twice.
    for (int tries = 0; tries < kPatience_ms / kNap_ms; ++tries) {
      if (waitpid(id_, nullptr, WNOHANG) != 0) break;
      ::usleep(1000 * kNap_ms);
    }
    kill(-id_, SIGKILL);
    wait();
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
  ChildGroup group_;
};

std::vector<char*> pointers(std::vector<std::string>& strings) {
  std::vector<char*> list;
  list.reserve(strings.size() + 1);
  for (std::string& s : strings) list.push_back(s.data());
  list.push_back(nullptr);
  return list;
}

std::vector<std::string> child_environment(const std::vector<std::pair<std::string, std::string>>& added) {
  std::vector<std::string> result;
  for (char** variable = environ; *variable; ++variable) {
    const std::string text = *variable;
    bool replaced = false;
    for (const auto& [name, value] : added)
      replaced |= text.compare(0, name.size(), name) == 0 && text[name.size()] == '=';
    if (!replaced) result.push_back(text);
  }
  for (const auto& [name, value] : added) result.emplace_back(name).append("=").append(value);
  return result;
}

/// In the child: only calls that are safe after fork.
[[noreturn]] void become(int output, pid_t parent, char* const* arguments, char* const* environment) {
  setpgid(0, 0);  // what it starts is ended with it
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(kNotStarted);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (nothing >= 0) dup2(nothing, STDIN_FILENO);
  execvpe(arguments[0], arguments, environment);
  _exit(kNotStarted);
}

/// Lines of a pipe's end, without their line breaks. Wakes up now and then to notice signals of ours, which a
/// program that prints nothing for minutes would hide.
class LineReader {
 public:
  LineReader(int end, const std::function<void()>& on_wait) : end_(end), on_wait_(on_wait) {}
  ~LineReader() { close(end_); }
  LineReader(const LineReader&) = delete;
  LineReader& operator=(const LineReader&) = delete;

  /// False at the end of the output.
  bool next(std::string& line) {
    size_t length = 0;
    while ((length = text_.find('\n')) == std::string::npos && !closed_) fill();
    if (length == std::string::npos && text_.empty()) return false;
    line = text_.substr(0, length);
    text_.erase(0, length == std::string::npos ? length : length + 1);
    while (!line.empty() && line.back() == '\r') line.pop_back();
    return true;
  }

 private:
  void fill() {
    throw_if_interrupted();
    if (on_wait_) on_wait_();
    pollfd waiting{end_, POLLIN, 0};
    if (poll(&waiting, 1, kWake_ms) <= 0) return;  // nothing yet, or a signal
    char bytes[4096];
    const ssize_t count = read(end_, bytes, sizeof bytes);
    if (count > 0)
      text_.append(bytes, static_cast<size_t>(count));
    else if (count == 0 || errno != EINTR)
      closed_ = true;
  }

  int end_;
  const std::function<void()>& on_wait_;
  bool closed_ = false;
  std::string text_;
};

}  // namespace

ProcessResult run_process(const std::vector<std::string>& arguments,
                          const std::vector<std::pair<std::string, std::string>>& environment,
                          const std::function<void(const std::string&)>& on_line,
                          const std::function<void()>& on_wait) {
  std::vector<std::string> argument_copy = arguments, variables = child_environment(environment);
  const std::vector<char*> argument_list = pointers(argument_copy), variable_list = pointers(variables);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0)
    throw TryAgainError(arguments[0], std::string("cannot be started: ") + std::strerror(errno),
                        "run the command again");
  const pid_t parent = getpid(), id = fork();
  if (id == 0) become(ends[1], parent, argument_list.data(), variable_list.data());
  close(ends[1]);
  LineReader output(ends[0], on_wait);
  if (id < 0)
    throw TryAgainError(arguments[0], std::string("cannot be started: ") + std::strerror(errno),
                        "run the command again");
  setpgid(id, id);  // here too: whoever comes first
  Child child(id);
  ProcessResult result;
  for (std::string line; output.next(line);) {
    if (result.last_lines.size() == kKeptLines) result.last_lines.erase(result.last_lines.begin());
    result.last_lines.push_back(line);
    if (on_line) on_line(line);
  }
  result.exit_code = child.wait();
  if (result.exit_code == kNotStarted && result.last_lines.empty())
    throw InputError(arguments[0], "", "cannot be started", "check the path");
  return result;
}

}  // namespace ohb
