// How a program ends before its time: SIGINT and SIGTERM, or a library that finds no memory. Work that can
// save something asks throw_if_interrupted() at its safe places; whatever goes on without asking is ended
// from outside a moment later, with nothing half-written left behind and no child running on.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <string>

namespace ohb {

/// Installs the handlers and starts the thread that ends the process once its grace is over. Called once,
/// first thing in a program's main(). Throws TryAgainError where no thread can be started.
void catch_interrupts(const std::string& program);

/// Throws TryAgainError if a signal has arrived. Cheap; called from any thread.
void throw_if_interrupted();
bool is_interrupted();

/// From the signal on, work has so long to come to a safe place by itself (at first 1 s). A second signal
/// ends the process at once.
void set_interrupt_grace_s(double seconds);

/// A file or folder in the making: removed if the process ends before this object does.
class Unfinished {
 public:
  explicit Unfinished(const std::filesystem::path& path);
  ~Unfinished();
  Unfinished(const Unfinished&) = delete;
  Unfinished& operator=(const Unfinished&) = delete;

 private:
  std::filesystem::path path_;
};

/// Runs the step, a rename of something unfinished, either before the process ends or never: not while it is
/// being removed.
void hold_off_ending(const std::function<void()>& step);

/// What must be written to its end (a checkpoint): while such an object lives, only a second signal or a
/// minute ends the process.
class Finishing {
 public:
  Finishing();
  ~Finishing();
  Finishing(const Finishing&) = delete;
  Finishing& operator=(const Finishing&) = delete;
};

/// A child that leads a process group of its own: killed with its group if the process ends before this
/// object does.
class ChildGroup {
 public:
  explicit ChildGroup(pid_t leader);
  ~ChildGroup();
  ChildGroup(const ChildGroup&) = delete;
  ChildGroup& operator=(const ChildGroup&) = delete;

 private:
  pid_t leader_;
};

/// Ends the process now: kills the children, removes what is unfinished, prints "program: words" and exits
/// with the code, without destructors. For any thread, however little memory there is.
[[noreturn]] void end_process(int code, const char* words);

}  // namespace ohb
