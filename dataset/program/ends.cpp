#include "dataset/program/ends.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <new>
#include <nlohmann/json.hpp>
#include <system_error>

#include "dataset/model/error.h"
#include "dataset/model/interrupt.h"

namespace ohb::program {
namespace fs = std::filesystem;
namespace {

struct End {
  int code;
  std::string words;
};

const char* g_memory_mend =
    "free some memory and run the command again";  // set once, before there are threads
bool g_has_ended = false;

End no_memory() {
  return {kExitTryAgain, std::string("not enough memory; ") + g_memory_mend};
}

bool is_of_memory(const std::error_code& code) {
  return code.value() == ENOMEM || code.value() == EAGAIN;
}

End end_of(const fs::filesystem_error& error) {
  if (is_of_memory(error.code())) return no_memory();
  std::string words = error.path1().string();
  if (!error.path2().empty()) words += ", " + error.path2().string();
  words += (words.empty() ? "" : ": ") + error.code().message();
  const int value = error.code().value();
  if (value == ENOSPC || value == EDQUOT || value == EFBIG)
    return {kExitTryAgain, words + "; free some space and run the command again"};
  return {kExitBadInput, words + "; check the path and the permissions of its folders"};
}

std::string one_line(std::string words) {
  for (char& c : words)
    if (c == '\n' || c == '\r') c = ' ';
  return words;
}

/// Of the exception in flight.
End end_of_current_exception() {
  try {
    throw;
  } catch (const TryAgainError& error) {
    return {kExitTryAgain, error.what()};
  } catch (const InputError& error) {
    // A child that the same signal ended, a folder that is gone already.
    if (is_interrupted()) return {kExitTryAgain, "stopped by a signal; run the same command again to go on"};
    return {kExitBadInput, error.what()};
  } catch (const std::bad_alloc&) {
    return no_memory();
  } catch (const fs::filesystem_error& error) {
    return end_of(error);
  } catch (const std::system_error& error) {
    if (is_of_memory(error.code())) return no_memory();
    return {kExitBug, std::string("a bug: ") + error.what() + "; please report it with the command line"};
  } catch (const nlohmann::json::exception& error) {
    // Readers name the file; this is for the value that one of them takes on trust.
    return {kExitBadInput,
            std::string("a JSON file does not hold what it should: ") + error.what() + "; make it again"};
  } catch (const std::exception& error) {
    if (speaks_of_memory(error.what())) return no_memory();
    return {kExitBug, "a bug: " + one_line(error.what()) + "; please report it with the command line"};
  } catch (...) {
    return {kExitBug, "a bug: an unknown exception; please report it with the command line"};
  }
}

/// What libraries take: OpenBLAS 128 MiB for each thread that uses it, without an end to asking; and stacks.
constexpr rlim_t kStart_bytes = rlim_t{256} << 20, kStartOfThread_bytes = rlim_t{144} << 20;

/// Pages of this process, by system calls alone: the libraries are not ready yet.
rlim_t mapped_bytes() {
  char text[64] = {};
  const int file = ::open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
  if (file < 0) return 0;
  const ssize_t count = ::read(file, text, sizeof text - 1);
  ::close(file);
  rlim_t pages = 0;
  for (const char* c = text; count > 0 && *c >= '0' && *c <= '9'; ++c)
    pages = 10 * pages + static_cast<rlim_t>(*c - '0');
  return pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE));
}

[[noreturn]] void on_terminate();

/// Before any library starts: OpenBLAS would ask for ever for memory that a limit (ulimit -v) denies, and
/// what others throw meanwhile finds no main() that catches it.
void before_libraries(int, char**, char**) {
  std::set_terminate(on_terminate);
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
  const rlim_t threads = static_cast<rlim_t>(std::max(1L, ::sysconf(_SC_NPROCESSORS_ONLN)));
  if (mapped_bytes() + kStart_bytes + threads * kStartOfThread_bytes <= limit.rlim_cur) return;
  constexpr char kWords[] =
      "not enough memory to start: the limit of address space (ulimit -v) is too low; raise it\n";
  if (::write(STDERR_FILENO, kWords, sizeof kWords - 1) > 0) ::_exit(kExitTryAgain);
  ::_exit(kExitTryAgain);
}

// Of a program's own, unlike a constructor, this runs before the constructors of its shared libraries.
__attribute__((section(".preinit_array"), used)) void (*g_before_libraries)(int, char**,
                                                                            char**) = before_libraries;

[[noreturn]] void on_terminate() {
  if (!std::current_exception())
    end_process(kExitBug, "a bug: terminated; please report it with the command line");
  const End end = end_of_current_exception();
  end_process(end.code, end.words.c_str());
}

/// Of an exit() that is not ours: OpenMP and OpenBLAS leave so where they find no thread or no memory.
void on_exit() {
  if (!g_has_ended) end_process(kExitTryAgain, no_memory().words.c_str());
}

}  // namespace

int run_program(const std::string& program, const char* memory_mend, const std::function<int()>& body) {
  g_memory_mend = memory_mend;
  End end{kExitDone, ""};
  try {
    catch_interrupts(program);
    std::atexit(on_exit);
    end.code = body();
  } catch (...) {
    end = end_of_current_exception();
  }
  if (!end.words.empty()) std::fprintf(stderr, "%s: %s\n", program.c_str(), end.words.c_str());
  g_has_ended = true;
  return end.code;
}

}  // namespace ohb::program
