// The program humanmaterial from outside: exit codes, words, stopping and going on.
#include <csignal>
#include <cstdlib>
#include <thread>

#include "learner/checkpoint.h"
#include "test_program.h"
#include "test_samples.h"
#include "tests/support/paths.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace learner;
namespace {

std::vector<std::string> training(const TemporaryFolder& folder, const std::string& steps) {
  return {"train",     "rss",
          "--data",    folder / "data",
          "-o",        folder / "run",
          "--width",   "0.125",
          "--size",    "16",
          "--steps",   steps,
          "--threads", "1",
          "--json",    "--checkpoint-every",
          "100000"};
}

TEST(Program, SaysWhatItIs) {
  TemporaryFolder folder;
  const Result version = run(folder, {"--version"});
  EXPECT_EQ(version.code, 0);
  EXPECT_NE(version.out.find("libtorch"), std::string::npos) << version.out;
  for (const char* command : {"train", "evaluate", "stress", "chart", "estimate", "relight", "torchscript"}) {
    const Result help = run(folder, {command, "--help"});
    EXPECT_EQ(help.code, 0);
    EXPECT_NE(help.out.find("Examples:"), std::string::npos) << help.out;
  }
}

TEST(Program, PresetsAreOptionsThatOthersGoBefore) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 2, 1, 16);
  std::vector<std::string> words = training(folder, "2");
  for (const char* word : {"--preset", "best", "--learning-rate", "0.25"}) words.push_back(word);
  const Result result = run(folder, words);
  ASSERT_EQ(result.code, 0) << result.error;
  const nlohmann::json header = read_checkpoint_header(*newest_checkpoint(folder / "run"));
  for (const char* flag : {"average", "parts", "mirror", "recolour", "snapshots", "balanced"})
    EXPECT_EQ(header[flag], true) << flag;
  EXPECT_EQ(header["batch"], 2);
  EXPECT_EQ(header["learning_rate"], 0.25) << "given";
  EXPECT_EQ(header["width"], 0.125);
  words = training(folder, "2");
  words[5] = folder / "fast";  // -o
  for (const char* word : {"--preset", "fast"}) words.push_back(word);
  ASSERT_EQ(run(folder, words).code, 0);
  const nlohmann::json fast = read_checkpoint_header(*newest_checkpoint(folder / "fast"));
  EXPECT_EQ(fast["learning_rate"], 1e-3);
  EXPECT_EQ(fast["cosine"], true);
  EXPECT_EQ(fast["render_weight"], 0);
  EXPECT_EQ(run(folder, {"train", "rss", "--preset", "cheap", "--data", "d", "-o", "o"}).code, 2);
}

TEST(Program, ResultsThatNobodyGetsAreNoSuccess) {
  for (const char* option : {" --version", " train --help"}) {
    const int status =
        std::system((program_path("humanmaterial") + option + " > /dev/full 2> /dev/null").c_str());
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 75) << option;
  }
}

TEST(Program, BadInputIsTwoAndOneLine) {
  TemporaryFolder folder;
  const std::vector<std::vector<std::string>> commands = {
      {},
      {"cook"},
      {"train", "geometry"},
      {"train", "cooking", "--data", folder / "data", "-o", folder / "run"},
      {"train", "rss", "--data", folder / "none", "-o", folder / "run"},
      {"evaluate", folder / "none", "--data", folder / "none"},
      {"estimate", folder / "none.png", "--weights", folder / "none", "-o", folder / "maps"}};
  for (const auto& command : commands) {
    const Result result = run(folder, command);
    EXPECT_EQ(result.code, 2) << (command.empty() ? "" : command[0]) << result.error;
    EXPECT_EQ(result.out, "");
    EXPECT_NE(result.error.find("humanmaterial: "), std::string::npos);
  }
}

TEST(Program, TerminationSavesAndResumeGoesOnBitForBit) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 1, 2, 16);
  std::vector<std::string> command = training(folder, "400");
  Program first(folder, command);
  // Until the run is under way.
  for (int i = 0; i < 600 && !std::filesystem::exists(folder / "run" / "log.jsonl"); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  first.send(SIGTERM);
  const Result stopped = first.wait();
  ASSERT_EQ(stopped.code, 75) << stopped.error;
  EXPECT_NE(stopped.error.find("--resume"), std::string::npos);
  const auto newest = newest_checkpoint(folder / "run");
  ASSERT_TRUE(newest);
  EXPECT_LT(read_checkpoint_header(*newest)["step"], 400);
  EXPECT_EQ(run(folder, command).code, 2) << "not without --resume";
  command.push_back("--resume");
  const Result resumed = run(folder, command);
  ASSERT_EQ(resumed.code, 0) << resumed.error;
  EXPECT_GT(nlohmann::json::parse(resumed.out)["first_step"], 0);
  std::filesystem::rename(folder / "run", folder / "stopped");
  ASSERT_EQ(run(folder, training(folder, "400")).code, 0);
  EXPECT_EQ(read_file(folder / "run" / kWeightsName), read_file(folder / "stopped" / kWeightsName));
}

// OpenBLAS says on stderr which processor's kernels it takes, if OPENBLAS_VERBOSE is set: once for each
// start.
TEST(Program, MatrixProductsRunOnWhatTheProcessorHas) {
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) GTEST_SKIP() << "an old processor";
  const TemporaryFolder folder;
  ::setenv("OPENBLAS_VERBOSE", "2", 1);
  // The arguments are good, so that it starts again with what suits the processor; then the file is not
  // there.
  const Result result = run(folder, {"evaluate", "none", "--data", folder / "data", "-o", folder / "out"});
  ::unsetenv("OPENBLAS_VERBOSE");
  EXPECT_EQ(result.code, 2);
  const size_t last = result.error.rfind("Core: ");
  if (last == std::string::npos) GTEST_SKIP() << "the matrix library is not OpenBLAS";
  const std::string core = result.error.substr(last + 6);
  for (const char* without_avx : {"Prescott", "Core2", "Penryn", "Dunnington", "Nehalem", "Atom"})
    EXPECT_NE(core.rfind(without_avx, 0), 0u) << result.error;
}

}  // namespace
}  // namespace ohb
