// label and bake on a full disk, and killed.
#include <sys/resource.h>
#include <sys/wait.h>

#include <csignal>
#include <cstdio>

#include "dataset/commands/bake_scan.h"
#include "dataset/commands/label.h"
#include "dataset/model/error.h"
#include "tests/dataset/labelled_square.h"
#include "tests/support/paths.h"
#include "tests/support/scan_files.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace bake;
using namespace commands;
using namespace labelling;
using namespace surface;
namespace {

namespace fs = std::filesystem;

const std::string kProgram = program_path("openhumanbrdf");

/// Starts `openhumanbrdf bake` of the square in a process of its own, which may write files of that size
/// only.
pid_t start_bake(const Square& square, rlim_t largest_file) {
  const pid_t child = ::fork();
  if (child != 0) return child;
  if (!std::freopen("/dev/null", "w", stdout)) ::_exit(126);
  // The kernel refuses to write beyond the limit, as a full disk would.
  ::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{largest_file, largest_file};
  ::setrlimit(RLIMIT_FSIZE, &limit);
  ::execl(kProgram.c_str(), kProgram.c_str(), "bake", square.bake.scan.c_str(), "--regions",
          square.bake.regions.c_str(), "-o", square.bake.output.c_str(), "--json", nullptr);
  ::_exit(127);
}

int exit_code_of(pid_t child) {
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(LabelBake, FullDiskIsToldApartAndLeavesNothing) {
  Square square;
  label_scan(square.label);
  const size_t before = entries_of(square.folder.path());
  // Where in a file the disk is full must not matter: header, texels, or what buffers hold back to the end.
  for (rlim_t largest_file : {20, 300, 600}) {
    EXPECT_EQ(exit_code_of(start_bake(square, largest_file)), kExitTryAgain) << largest_file;
    EXPECT_EQ(entries_of(square.folder.path()), before);
  }
  EXPECT_EQ(exit_code_of(start_bake(square, RLIM_INFINITY)), kExitDone);
  EXPECT_EQ(entries_of(square.folder.path()), before + 1);
}

TEST(LabelBake, KilledHalfwayLeavesNoModel) {
  Square square;
  write_small_png(square.folder / "p.png", 3, 1024);
  label_scan(square.label);
  const pid_t child = start_bake(square, RLIM_INFINITY);
  ::usleep(100000);
  ::kill(child, SIGKILL);
  if (exit_code_of(child) == kExitDone) GTEST_SKIP() << "the bake was faster than the kill";
  EXPECT_FALSE(fs::exists(square.bake.output));
  bake_scan(square.bake);  // and it can be made afterwards
  EXPECT_EQ(read_model(square.bake.output).sets.size(), 1u);
}

}  // namespace
}  // namespace ohb
