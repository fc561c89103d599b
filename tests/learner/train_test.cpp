// Checkpoints that survive anything, and runs that go on bit for bit.
#include "learner/train.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <csignal>
#include <fstream>

#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/temporary.h"
#include "learner/safetensors.h"
#include "test_samples.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace learner;
namespace {

using nlohmann::json;

json small_header(int64_t step) {
  return {{"format", 1}, {"task", "rss"}, {"width", 0.125}, {"size_px", 16}, {"step", step}};
}

TrainOptions options_of(const TemporaryFolder& folder, const std::string& run, int64_t steps) {
  TrainOptions o;
  o.task = Task::kRss;
  o.data = folder / "data";
  o.run = folder / run;
  o.width = 0.125;
  o.size_px = 16;
  o.steps = steps;
  o.learning_rate = 1e-3;
  o.warmup = 2;
  o.threads = 2;
  o.checkpoint_every = 1000;
  o.log_every = 1;
  o.quiet = true;
  return o;
}

std::vector<json> log_of(const std::filesystem::path& run) {
  std::vector<json> lines;
  std::ifstream stream(run / "log.jsonl");
  for (std::string line; std::getline(stream, line);) lines.push_back(json::parse(line));
  return lines;
}

TEST(Checkpoint, ComesBackBitForBit) {
  TemporaryFolder folder;
  const Network network = make_network(Task::kRss, 0.125);
  AdamW optimiser(network.module(), {});
  for (auto& s : optimiser.states()) s.first.uniform_(), s.second.uniform_();
  save_checkpoint(folder.path(), small_header(12), optimiser, 2);
  const Network other = make_network(Task::kRss, 0.125);
  AdamW loaded(other.module(), {});
  EXPECT_EQ(load_checkpoint(*newest_checkpoint(folder.path()), loaded)["step"], 12);
  for (size_t i = 0; i < loaded.states().size(); ++i) {
    EXPECT_TRUE(loaded.states()[i].parameter.equal(optimiser.states()[i].parameter));
    EXPECT_TRUE(loaded.states()[i].first.equal(optimiser.states()[i].first));
    EXPECT_TRUE(loaded.states()[i].second.equal(optimiser.states()[i].second));
  }
}

TEST(Checkpoint, KeepsTheNewestFew) {
  TemporaryFolder folder;
  const Network network = make_network(Task::kRss, 0.125);
  AdamW optimiser(network.module(), {});
  for (const int64_t step : {5, 90, 100, 1000})
    save_checkpoint(folder.path(), small_header(step), optimiser, 2);
  EXPECT_FALSE(std::filesystem::exists(checkpoint_file(folder.path(), 90)));
  EXPECT_TRUE(std::filesystem::exists(checkpoint_file(folder.path(), 100)));
  EXPECT_EQ(*newest_checkpoint(folder.path()), checkpoint_file(folder.path(), 1000));
  EXPECT_FALSE(newest_checkpoint(folder / "nothing"));
}

TEST(Checkpoint, RefusesWhatDoesNotFitInWords) {
  TemporaryFolder folder;
  const Network small = make_network(Task::kRss, 0.125), wide = make_network(Task::kRss, 0.25);
  AdamW of_small(small.module(), {}), of_wide(wide.module(), {});
  save_checkpoint(folder.path(), small_header(1), of_small, 2);
  const auto file = checkpoint_file(folder.path(), 1);
  const torch::Tensor before = of_wide.states()[0].parameter.clone();
  expect_message(input_error_of([&] { load_checkpoint(file, of_wide); }), {"step_00000001", "another shape"});
  EXPECT_TRUE(before.equal(of_wide.states()[0].parameter)) << "nothing is changed";
  {
    torch::NoGradGuard guard;
    of_small.states()[3].parameter.view(-1)[0].fill_(std::nanf(""));
  }
  save_checkpoint(folder.path(), small_header(2), of_small, 2);
  expect_message(input_error_of([&] { load_network(folder.path()); }), {"step_00000002", "NaN"});
  for (const auto& [key, value, words] :
       std::vector<std::tuple<std::string, json, std::string>>{{"format", 2, "another format"},
                                                               {"task", "cooking", "no model"},
                                                               {"width", 1e9, "width"},
                                                               {"width", "wide", "width"},
                                                               {"size_px", -16, "size"},
                                                               {"size_px", 24, "size"},
                                                               {"trained_on", nullptr, "trained_on"},
                                                               {"held_out", {"ada", 2}, "held_out"},
                                                               {"step", 1e300, "step"},
                                                               {"step", -1, "step"}}) {
    json header = small_header(3);
    header[key] = value;
    write_tensors(folder / "x.safetensors", {{}, {{"humanmaterial", header.dump()}}});
    expect_message(input_error_of([&] { load_network(folder / "x.safetensors"); }), {"x.safetensors", words});
  }
  write_tensors(folder / "x.safetensors", {{}, {}});
  expect_message(input_error_of([&] { load_network(folder / "x.safetensors"); }), {"not of a humanmaterial"});
  write_tensors(folder / "x.safetensors", {{}, {{"humanmaterial", "{"}}});
  expect_message(input_error_of([&] { load_network(folder / "x.safetensors"); }), {"not well-formed"});
  expect_message(input_error_of([&] { load_network(folder / "none"); }), {"no such file"});
}

// Killed at any moment of writing, the newest checkpoint is a whole one.
TEST(Checkpoint, KillDuringWritesNeverLosesTheLastGoodOne) {
  TemporaryFolder folder;
  const Network network = make_network(Task::kRss, 0.125);
  AdamW optimiser(network.module(), {});
  save_checkpoint(folder.path(), small_header(1), optimiser, 2);
  int64_t step = 1;
  // Later children live longer: on a slow disk it takes more of them until enough is written.
  for (int kill = 0; kill < 20 || (step <= 20 && kill < 200); ++kill) {
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      for (int64_t next = step + 1;; ++next) save_checkpoint(folder.path(), small_header(next), optimiser, 2);
    }
    ::usleep(static_cast<useconds_t>(2000 + 3700 * kill));
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
    const auto newest = newest_checkpoint(folder.path());
    ASSERT_TRUE(newest);
    const int64_t now = load_checkpoint(*newest, optimiser)["step"];
    EXPECT_GE(now, step);
    step = now;
  }
  EXPECT_GT(step, 20) << "the writer did get to write";
  sweep_leftovers(folder.path());
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    EXPECT_EQ(entry.path().filename().string().rfind("step_", 0), 0u) << entry.path();
}

class TrainingOfTask : public testing::TestWithParam<Task> {};

TEST_P(TrainingOfTask, LossFallsOnTwoBalls) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 2, 2, 32);
  TrainOptions o = options_of(folder, name_of(GetParam()), 60);
  o.task = GetParam();
  o.size_px = 32;
  const TrainReport report = train(o);
  EXPECT_EQ(report.skipped, 0);
  EXPECT_LT(report.last_loss, 0.8 * report.first_loss);
  EXPECT_TRUE(std::filesystem::exists(report.weights));
  const LoadedNetwork loaded = load_network(report.weights);
  EXPECT_EQ(loaded.network.task, GetParam());
  EXPECT_EQ(loaded.header["trained_on"].size(), 1u);
  EXPECT_EQ(loaded.header["held_out"].size(), 1u);
}
INSTANTIATE_TEST_SUITE_P(All, TrainingOfTask, testing::ValuesIn(kTasks),
                         [](const auto& info) { return std::string(name_of(info.param)); });

TEST(Training, TheFinetuningModelLearnsOnThePriorsEstimates) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 2, 2, 16);
  for (const Task task : {Task::kRss, Task::kGeometry, Task::kAlbedo}) {
    TrainOptions prior = options_of(folder, name_of(task), 1);
    prior.task = task;
    train(prior);
  }
  TrainOptions o = options_of(folder, "on_priors", 5);
  o.task = Task::kFinetune;
  o.guidance = Guidance::kPriors;
  o.priors = {folder / "rss", folder / "geometry", folder / "albedo"};
  EXPECT_EQ(train(o).skipped, 0);
  o.priors[0] = folder / "albedo";
  expect_message(input_error_of([&] { PriorSet{o.priors}; }), {"albedo", "second"});
}

TEST(Training, ResumedRunEqualsAnUninterruptedOneBitForBit) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 2, 3, 32);
  TrainOptions whole = options_of(folder, "whole", 20);
  whole.mirror = whole.recolour = whole.balanced = whole.average = whole.parts = true;
  train(whole);
  TrainOptions first = whole;
  first.run = folder / "parts";
  first.checkpoint_every = 10;
  // As if killed after step 13: the checkpoint of step 10 is the last, the log goes further.
  train(first);
  std::filesystem::remove(checkpoint_file(first.run, 20));
  std::filesystem::remove(first.run / kWeightsName);
  first.resume = true;
  EXPECT_EQ(train(first).first_step, 10);
  EXPECT_EQ(read_file(checkpoint_file(folder / "whole", 20)),
            read_file(checkpoint_file(folder / "parts", 20)));
  EXPECT_EQ(read_file(folder / "whole" / kWeightsName), read_file(folder / "parts" / kWeightsName));
  // Each step is in the log once.
  std::map<int64_t, int> seen;
  for (const json& line : log_of(first.run))
    if (line.contains("loss")) ++seen[line["step"]];
  EXPECT_EQ(seen.size(), 20u);
  for (const auto& [step, count] : seen) EXPECT_EQ(count, 1) << step;
}

// The average by its definition: the same run's weights at each step, weighted by hand.
TEST(Training, AveragesAreThoseOfTheStepsWeights) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 1, 2, 16);
  TrainOptions o = options_of(folder, "run", 12);
  o.average = true;
  o.checkpoint_every = 1;
  o.keep = 100;
  const TrainReport report = train(o);
  torch::manual_seed(o.seed);
  const Network start = make_network(o.task, o.width);
  std::vector<torch::Tensor> wanted;
  for (const auto& parameter : start.module().parameters())
    wanted.push_back(parameter.detach().to(torch::kDouble));
  for (int64_t step = 1; step <= 12; ++step) {
    const Network network = make_network(o.task, o.width);
    AdamW::Options with_average;
    with_average.average_decay = 0.9995;
    AdamW optimiser(network.module(), with_average);
    load_checkpoint(checkpoint_file(o.run, step), optimiser);
    const double decay = static_cast<double>(step) / (10 + static_cast<double>(step));
    for (size_t i = 0; i < wanted.size(); ++i)
      wanted[i] =
          decay * wanted[i] + (1 - decay) * optimiser.states()[i].parameter.detach().to(torch::kDouble);
  }
  for (const auto& file : {report.weights, checkpoint_file(o.run, 12)}) {
    const auto loaded = load_network(file).network.module().parameters();
    for (size_t i = 0; i < wanted.size(); ++i)
      EXPECT_TRUE(torch::allclose(loaded[i].to(torch::kDouble), wanted[i], 2e-3, 2e-4)) << i;
  }
  o.average = false;
  o.resume = true;
  expect_message(input_error_of([&] { train(o); }), {"average", "true"});
}

TEST(Training, BeginsWithGivenWeightsAndRemembersWhomTheySaw) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 3, 1, 16);
  TrainOptions before = options_of(folder, "before", 3);
  before.held_out = {"person1", "person2"};
  const TrainReport report = train(before);
  TrainOptions o = options_of(folder, "after", 2);
  o.held_out = {"person0", "person2"};
  o.from = report.weights;
  o.learning_rate = 1e-12;
  o.mix_lights = true;
  train(o);
  const auto start = load_network(report.weights), end = load_network(o.run);
  const auto a = start.network.module().parameters(), b = end.network.module().parameters();
  for (size_t i = 0; i < a.size(); ++i) EXPECT_TRUE(torch::allclose(a[i], b[i], 0, 1e-6)) << i;
  EXPECT_EQ(end.header["trained_on"], (std::vector<std::string>{"person0", "person1"}));
  o.resume = true;
  o.from.clear();
  expect_message(input_error_of([&] { train(o); }), {"in the run"});
  o = options_of(folder, "other", 2);
  o.from = report.weights;
  o.width = 0.25;
  expect_message(input_error_of([&] { train(o); }), {"weights.safetensors", "rss, width 0.125", "--width"});
}

TEST(Training, RefusesToMixRuns) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 1, 1, 16);
  TrainOptions o = options_of(folder, "run", 3);
  EXPECT_EQ(train(o).steps, 3) << "one sample is enough";
  expect_message(input_error_of([&] { train(o); }), {"holds a run already", "--resume"});
  o.resume = true;
  o.learning_rate = 5e-3;
  expect_message(input_error_of([&] { train(o); }), {"learning_rate", "0.001", "0.005"});
  o = options_of(folder, "run", 3);
  o.resume = o.recolour = true;
  expect_message(input_error_of([&] { train(o); }), {"recolour", "unset", "true"});
  o.recolour = false;
  o.control_roughness = 0.8;
  expect_message(input_error_of([&] { train(o); }), {"control_roughness", "unset", "0.8"});
  o.control_roughness = kGeometryRoughness;
  EXPECT_EQ(train(o).first_step, 3) << "a finished run stays as it is";
  // Views rendered again by other settings, or one more.
  const auto view = folder / "data" / "person0" / "view_000.exr";
  Sample sample = read_sample(view);
  sample.attributes.emplace_back("ohb:modelHash", "another");
  write_sample(view, sample);
  expect_message(input_error_of([&] { train(o); }), {"views", "rendered again", "another -o"});
  write_ball_dataset(folder / "data", 1, 2, 16);
  expect_message(input_error_of([&] { train(o); }), {"views"});
  std::filesystem::remove(folder / "data" / "person0" / "view_001.exr");
  EXPECT_EQ(train(o).first_step, 3);
}

TEST(Training, RefusesOtherPriorsAndFoldersThatAreNoRuns) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 1, 1, 16);
  TrainOptions o = options_of(folder, "run", 2);
  o.task = Task::kFinetune;
  o.guidance = Guidance::kPriors;
  const auto write_priors = [&](int seed) {
    o.priors.clear();
    for (const Task task : {Task::kGeometry, Task::kAlbedo, Task::kRss}) {
      torch::manual_seed(seed);
      json header = small_header(0);
      header["task"] = name_of(task);
      o.priors.push_back(folder / (std::string(name_of(task)) + ".safetensors"));
      save_weights(o.priors.back(), header, make_network(task, 0.125));
    }
  };
  write_priors(1);
  train(o);
  o.resume = true;
  EXPECT_EQ(train(o).first_step, 2);
  write_priors(2);
  expect_message(input_error_of([&] { train(o); }), {"priors", "in the run", "now"});
  o = options_of(folder, "model", 2);
  claim_folder(o.run, "model");
  expect_message(input_error_of([&] { train(o); }), {"holds model", "a training run would be"});
  o = options_of(folder, "weights", 2);
  make_folders(o.run);
  write_file_atomically(o.run / kWeightsName, std::string("somebody's"));
  expect_message(input_error_of([&] { train(o); }), {"holds weights.safetensors", "another -o"});
  EXPECT_EQ(read_file(o.run / kWeightsName), "somebody's");
}

TEST(Training, RefusesBadOptionsInWords) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 1, 1, 16);
  const auto message = [&](const std::function<void(TrainOptions&)>& change) {
    TrainOptions o = options_of(folder, "run", 3);
    change(o);
    return input_error_of([&] { train(o); });
  };
  expect_message(message([](TrainOptions& o) { o.size_px = 20; }), {"--size 20", "multiple of 16"});
  expect_message(message([](TrainOptions& o) { o.size_px = 32; }), {"view_000.exr", "--size 32"});
  expect_message(message([](TrainOptions& o) { o.width = 0; }), {"--width"});
  expect_message(message([](TrainOptions& o) { o.batch = 0; }), {"--batch"});
  expect_message(message([](TrainOptions& o) { o.learning_rate = -1; }), {"--learning-rate"});
  expect_message(message([](TrainOptions& o) { o.guidance = Guidance::kPriors; }), {"finetune only"});
  expect_message(message([](TrainOptions& o) { o.data = o.data / "none"; }), {"no such folder"});
}

TEST(Training, NaNLossIsLeftOutAndNamed) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 1, 2, 16);
  TrainOptions o = options_of(folder, "run", 30);
  o.learning_rate = 1e30;  // throws the weights beyond float
  o.warmup = 0;
  expect_message(input_error_of([&] { train(o); }), {"view_00", "not finite", "--learning-rate"});
  int skipped = 0;
  for (const json& line : log_of(o.run))
    if (line.value("event", "") == "skipped") {
      ++skipped;
      EXPECT_NE(line["samples"][0].get<std::string>().find("view_00"), std::string::npos);
    }
  EXPECT_EQ(skipped, 10);
}

TEST(LearningRate, RisesAndFalls) {
  TrainOptions o;
  o.learning_rate = 1;
  o.warmup = 10;
  EXPECT_DOUBLE_EQ(learning_rate_at(o, 5, 1000), 0.5);
  EXPECT_DOUBLE_EQ(learning_rate_at(o, 10, 1000), 1);
  EXPECT_DOUBLE_EQ(learning_rate_at(o, 999, 1000), 1);
  o.cosine = true;
  EXPECT_NEAR(learning_rate_at(o, 505, 1000), 0.5, 1e-3);
  EXPECT_NEAR(learning_rate_at(o, 1000, 1000), 1e-6, 1e-9);
}

}  // namespace
}  // namespace ohb
