// Running another program: what comes back, and that none stays behind.
#include "dataset/model/process.h"

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>
#include <string>
#include <vector>

namespace ohb {
namespace {

TEST(Process, GivesLinesExitCodeAndEnvironment) {
  std::vector<std::string> lines;
  const auto result = run_process({"sh", "-c", "echo $OHB_A; echo two >&2; exit 3"}, {{"OHB_A", "one"}},
                                  [&](const std::string& line) { lines.push_back(line); });
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_EQ(lines, (std::vector<std::string>{"one", "two"}));
  EXPECT_EQ(result.last_lines, lines);
  EXPECT_EQ(run_process({"sh", "-c", "kill -9 $$"}, {}, nullptr).exit_code, 128 + 9);
}

TEST(Process, LinesOfAnyLengthComeWhole) {
  std::vector<std::string> lines;
  run_process({"sh", "-c", "printf 'a\\r\\n\\n'; head -c 100000 /dev/zero | tr '\\0' x; printf '\\nend'"}, {},
              [&](const std::string& line) { lines.push_back(line); });
  EXPECT_EQ(lines, (std::vector<std::string>{"a", "", std::string(100000, 'x'), "end"}));
}

TEST(Process, IsEndedWhenTheReaderThrows) {
  const auto start = std::chrono::steady_clock::now();
  EXPECT_THROW(run_process({"sh", "-c", "echo x; exec sleep 60"}, {},
                           [](const std::string&) { throw std::runtime_error("stop"); }),
               std::runtime_error);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
}

}  // namespace
}  // namespace ohb
