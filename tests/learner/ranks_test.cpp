// Several processes that train one network: their gradients, and what happens when one of them ends.
#include "learner/ranks.h"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <thread>

#include "free_port.h"
#include "learner/checkpoint.h"
#include "learner/safetensors.h"
#include "test_program.h"
#include "test_samples.h"

namespace ohb {
using namespace learner;
namespace {

namespace fs = std::filesystem;

/// As many processes, each with its own options after the common ones.
class RankPrograms {
 public:
  RankPrograms(const std::vector<std::string>& common, const std::vector<std::vector<std::string>>& own) {
    ::setenv("WORLD_SIZE", std::to_string(own.size()).c_str(), 1);
    ::setenv("MASTER_ADDR", "127.0.0.1", 1);
    ::setenv("MASTER_PORT", std::to_string(free_port()).c_str(), 1);
    ::setenv("GLOO_SOCKET_IFNAME", "lo", 1);
    for (size_t rank = 0; rank < own.size(); ++rank) {
      ::setenv("RANK", std::to_string(rank).c_str(), 1);
      std::vector<std::string> arguments = common;
      arguments.insert(arguments.end(), own[rank].begin(), own[rank].end());
      folders_.push_back(std::make_unique<TemporaryFolder>());
      programs_.push_back(std::make_unique<Program>(*folders_.back(), arguments));
    }
    for (const char* name : {"WORLD_SIZE", "MASTER_ADDR", "MASTER_PORT", "GLOO_SOCKET_IFNAME", "RANK"})
      ::unsetenv(name);
  }
  Program& rank(size_t i) { return *programs_[i]; }
  std::vector<Result> wait() {
    std::vector<Result> results;
    for (auto& program : programs_) results.push_back(program->wait());
    return results;
  }

 private:
  std::vector<std::unique_ptr<TemporaryFolder>> folders_;
  std::vector<std::unique_ptr<Program>> programs_;
};

std::vector<std::string> train_words(const TemporaryFolder& folder, const std::string& run, int steps) {
  return {"train",
          "geometry",
          "--data",
          (folder / "data").string(),
          "-o",
          (folder / run).string(),
          "--width",
          "0.125",
          "--size",
          "16",
          "--batch",
          "4",
          "--threads",
          "1",
          "--mirror",
          "--warmup",
          "0",
          "--log-every",
          "1",
          "--checkpoint-every",
          "5",
          "--steps",
          std::to_string(steps)};
}

class WithRanks : public ::testing::Test {
 protected:
  void SetUp() override {
    // The balls are of several sizes: parts of a batch must not weigh alike.
    write_ball_dataset(folder_ / "data", 3, 4, 16);
    ::setenv("WORLD_SIZE", "2", 1);
    ::setenv("RANK", "5", 1);
    const std::string words = input_error_of([] { Ranks::from_environment(); });
    ::unsetenv("WORLD_SIZE");
    ::unsetenv("RANK");
    if (words.find("cannot do") != std::string::npos) GTEST_SKIP() << "built without Gloo";
    expect_message(words, {"RANK", "5"});
  }
  TemporaryFolder folder_;
};

/// The first moments after one step: the clipped gradient times 0.1.
std::vector<torch::Tensor> moments_of(const fs::path& run, int64_t step) {
  std::vector<torch::Tensor> moments;
  for (const auto& [name, tensor] : read_tensors(checkpoint_file(run, step)).tensors)
    if (name.rfind("adam.first.", 0) == 0) moments.push_back(tensor.to(torch::kDouble).reshape(-1));
  return moments;
}

double relative_distance(const fs::path& a, const fs::path& b, int64_t step) {
  const torch::Tensor x = torch::cat(moments_of(a, step)), y = torch::cat(moments_of(b, step));
  return ((x - y).norm() / y.norm()).item<double>();
}

TEST_F(WithRanks, GradientsAreThoseOfTheJointBatch) {
  const Result alone = run(folder_, train_words(folder_, "alone", 1));
  ASSERT_EQ(alone.code, 0) << alone.error;
  for (const size_t count : {2, 4}) {
    const std::string name = "run" + std::to_string(count);
    RankPrograms ranks(train_words(folder_, name, 1), std::vector<std::vector<std::string>>(count));
    const std::vector<Result> results = ranks.wait();
    for (size_t i = 0; i < count; ++i) {
      ASSERT_EQ(results[i].code, 0) << results[i].error;
      EXPECT_EQ(results[i].out.empty(), i > 0) << "only rank 0 reports";
    }
    const double distance = relative_distance(folder_ / name, folder_ / "alone", 1);
    RecordProperty("relative_distance_" + std::to_string(count), std::to_string(distance * 1e9) + "e-9");
    EXPECT_LT(distance, 1e-6) << count << " ranks";
  }
}

TEST_F(WithRanks, AKilledRankEndsTheOthersInWordsAndResumeGoesOn) {
  {
    RankPrograms ranks(train_words(folder_, "run", 100000), std::vector<std::vector<std::string>>(2));
    for (int i = 0; i < 600 && !newest_checkpoint(folder_ / "run"); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    ASSERT_TRUE(newest_checkpoint(folder_ / "run"));
    ranks.rank(1).send(SIGKILL);
    const auto killed = std::chrono::steady_clock::now();
    const std::vector<Result> results = ranks.wait();
    EXPECT_LT(std::chrono::steady_clock::now() - killed, std::chrono::seconds(60));
    EXPECT_EQ(results[0].code, 75);
    EXPECT_NE(results[0].error.find("another rank has ended"), std::string::npos) << results[0].error;
  }
  const auto newest = newest_checkpoint(folder_ / "run");
  const int64_t step = read_checkpoint_header(*newest)["step"];
  // Two ranks more, or the same batch alone, go on from there, to the same weights up to rounding.
  fs::copy(folder_ / "run", folder_ / "alone", fs::copy_options::recursive);
  std::vector<std::string> words = train_words(folder_, "run", static_cast<int>(step) + 1);
  words.push_back("--resume");
  RankPrograms resumed(words, std::vector<std::vector<std::string>>(4));
  for (const Result& result : resumed.wait()) EXPECT_EQ(result.code, 0) << result.error;
  words = train_words(folder_, "alone", static_cast<int>(step) + 1);
  words.push_back("--resume");
  EXPECT_EQ(run(folder_, words).code, 0);
  EXPECT_LT(relative_distance(folder_ / "run", folder_ / "alone", step + 1), 1e-6);
}

TEST_F(WithRanks, ASignalToOneStopsAllAfterTheSameStep) {
  RankPrograms ranks(train_words(folder_, "run", 100000), std::vector<std::vector<std::string>>(2));
  for (int i = 0; i < 600 && !newest_checkpoint(folder_ / "run"); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  ranks.rank(1).send(SIGTERM);
  for (const Result& result : ranks.wait()) {
    EXPECT_EQ(result.code, 75);
    EXPECT_NE(result.error.find("which is saved"), std::string::npos) << result.error;
  }
}

TEST_F(WithRanks, ThatDisagreeAreRefused) {
  RankPrograms ranks(train_words(folder_, "run", 3), {{}, {"--learning-rate", "0.5"}});
  const std::vector<Result> results = ranks.wait();
  EXPECT_EQ(results[1].code, 2);
  EXPECT_NE(results[1].error.find("learning_rate"), std::string::npos) << results[1].error;
  EXPECT_EQ(results[0].code, 75) << results[0].error;
}

TEST_F(WithRanks, WantABatchThatDivides) {
  RankPrograms ranks(train_words(folder_, "run", 3), std::vector<std::vector<std::string>>(3));
  int refused = 0;  // the slower ones may find the others gone
  for (const Result& result : ranks.wait()) {
    EXPECT_TRUE(result.code == 2 || result.code == 75) << result.code << result.error;
    refused += result.code == 2 && result.error.find("WORLD_SIZE") != std::string::npos;
  }
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace ohb
