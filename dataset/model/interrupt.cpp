#include "dataset/model/interrupt.h"

#include <pthread.h>
#include <semaphore.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <ctime>
#include <list>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "dataset/model/error.h"

namespace ohb {
namespace fs = std::filesystem;
namespace {

constexpr double kLongestFinish_s = 60;
constexpr size_t kReserve_bytes = size_t{1} << 20;  // freed at the end, so that removing files finds memory
constexpr size_t kWatchStack_bytes = size_t{1} << 18;
constexpr const char* kStopped = "stopped by a signal; run the same command again to go on";

volatile std::sig_atomic_t g_interrupted = 0;
sem_t g_signals;  // one post a signal
std::atomic<double> g_grace_s{1};
std::atomic<int> g_finishing{0};
std::atomic<bool> g_ending{false};

/// What an end must clean up. The mutex is held by whoever ends the process, for good: from then on nothing
/// is begun and nothing is renamed.
struct Registry {
  std::timed_mutex mutex;
  std::list<fs::path> paths;
  std::list<pid_t> groups;
  std::string program;
  std::unique_ptr<char[]> reserve;
};

/// Never destroyed: threads of libraries may outlive the statics.
Registry& registry() {
  static Registry* const one = new Registry;
  return *one;
}

template <typename Item>
void erase_one(std::list<Item>& items, const Item& item) {
  for (auto i = items.begin(); i != items.end(); ++i)
    if (*i == item) {
      items.erase(i);
      return;
    }
}

void remember(int) {
  const int error = errno;
  g_interrupted = 1;
  sem_post(&g_signals);
  errno = error;
}

/// Whether another signal came within so many seconds.
bool signal_within(double seconds) {
  timespec until{};
  clock_gettime(CLOCK_REALTIME, &until);
  const double whole = static_cast<double>(until.tv_nsec) * 1e-9 + seconds;
  until.tv_sec += static_cast<time_t>(whole);
  until.tv_nsec = static_cast<long>((whole - static_cast<double>(static_cast<time_t>(whole))) * 1e9);
  while (sem_timedwait(&g_signals, &until) != 0)
    if (errno != EINTR) return false;
  return true;
}

void* watch(void*) {
  while (sem_wait(&g_signals) != 0) continue;
  if (!signal_within(g_grace_s)) {
    constexpr double kStep_s = 0.05;
    for (double waited = 0; g_finishing > 0 && waited < kLongestFinish_s; waited += kStep_s)
      if (signal_within(kStep_s)) break;
  }
  end_process(kExitTryAgain, kStopped);
}

void start_watch() {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kWatchStack_bytes);
  pthread_attr_setdetachstate(&attributes, PTHREAD_CREATE_DETACHED);
  pthread_t thread;
  const int error = pthread_create(&thread, &attributes, watch, nullptr);
  pthread_attr_destroy(&attributes);
  if (error != 0) throw TryAgainError("", "no thread can be started", "free some memory and run it again");
}

void kill_children(const std::list<pid_t>& groups) {
  for (const pid_t group : groups) ::kill(-group, SIGKILL);
  // Until they are gone: they might write into what is removed next.
  for (const pid_t group : groups)
    for (int tries = 0; tries < 100 && ::waitpid(group, nullptr, WNOHANG) == 0; ++tries) ::usleep(10000);
}

void say(const std::string& program, const char* words) {
  const std::string line = program + (program.empty() ? "" : ": ") + words + "\n";
  if (::write(STDERR_FILENO, line.data(), line.size()) < 0) return;
}

}  // namespace

void catch_interrupts(const std::string& program) {
  registry().program = program;
  registry().reserve = std::make_unique<char[]>(kReserve_bytes);
  sem_init(&g_signals, 0, 0);
  start_watch();
  std::signal(SIGINT, remember);
  std::signal(SIGTERM, remember);
  // A closed pipe or a file-size limit is reported by write(), with its cause.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

bool is_interrupted() {
  return g_interrupted != 0;
}

void throw_if_interrupted() {
  if (g_interrupted) throw TryAgainError("", "stopped by a signal", "run the same command again to go on");
}

void set_interrupt_grace_s(double seconds) {
  g_grace_s = seconds;
}

Unfinished::Unfinished(const fs::path& path) : path_(path) {
  const std::lock_guard<std::timed_mutex> lock(registry().mutex);
  registry().paths.push_back(path_);
}

Unfinished::~Unfinished() {
  const std::lock_guard<std::timed_mutex> lock(registry().mutex);
  erase_one(registry().paths, path_);
}

void hold_off_ending(const std::function<void()>& step) {
  const std::lock_guard<std::timed_mutex> lock(registry().mutex);
  step();
}

Finishing::Finishing() {
  ++g_finishing;
}

Finishing::~Finishing() {
  --g_finishing;
}

ChildGroup::ChildGroup(pid_t leader) : leader_(leader) {
  const std::lock_guard<std::timed_mutex> lock(registry().mutex);
  registry().groups.push_back(leader_);
}

ChildGroup::~ChildGroup() {
  const std::lock_guard<std::timed_mutex> lock(registry().mutex);
  erase_one(registry().groups, leader_);
}

void end_process(int code, const char* words) {
  // Whoever comes second (another thread, or this one because cleaning up failed too) must not wait.
  static std::atomic<pthread_t> first{};
  if (g_ending.exchange(true)) {
    if (pthread_equal(first, pthread_self())) ::_exit(code);
    for (;;) ::pause();
  }
  first = pthread_self();
  Registry& all = registry();
  all.reserve.reset();
  // The lock may be held by this very thread, if it failed inside: then go on without.
  const bool locked = all.mutex.try_lock_for(std::chrono::seconds(2));
  static_cast<void>(locked);
  kill_children(all.groups);
  // What comes into a folder while it is emptied is there for the second round.
  for (int round = 0; round < 2; ++round)
    for (const fs::path& path : all.paths) {
      std::error_code ignored;
      fs::remove_all(path, ignored);
    }
  say(all.program, words);
  ::_exit(code);
}

}  // namespace ohb
