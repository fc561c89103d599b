#include "dataset/model/interrupt.h"

#include <csignal>

#include "dataset/model/error.h"

namespace ohb {
namespace {

volatile std::sig_atomic_t g_interrupted = 0;

void remember(int) {
  g_interrupted = 1;
}

}  // namespace

void catch_interrupts() {
  std::signal(SIGINT, remember);
  std::signal(SIGTERM, remember);
  // A closed pipe or a file-size limit is reported by write(), with its cause.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

void throw_if_interrupted() {
  if (g_interrupted) throw TryAgainError("", "stopped by a signal", "run the same command again to go on");
}

}  // namespace ohb
