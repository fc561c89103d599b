// Training on a device that is not the CPU: nothing takes it for one, and what comes out is the same.
#include "fake_device.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>

#include "free_port.h"
#include "learner/chunked_loss.h"
#include "learner/data.h"
#include "learner/estimator.h"
#include "learner/ranks.h"
#include "learner/safetensors.h"
#include "learner/train.h"
#include "test_losses.h"
#include "test_samples.h"
#include "test_weights.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace learner;
namespace {

using torch::Tensor;

TEST(FakeDevice, FailsWhoeverTakesItForTheCpu) {
  const Tensor there = torch::rand({2, 3}).to(fake_device()), here = torch::rand({2, 3});
  EXPECT_EQ(there.device(), fake_device());
  EXPECT_ANY_THROW(there + here);
  EXPECT_ANY_THROW(here.mul(there));
  EXPECT_ANY_THROW(torch::cat({there, here}));
  EXPECT_TRUE(torch::allclose((there + 1).to(torch::kCPU), there.to(torch::kCPU) + 1));
  EXPECT_DEATH(std::printf("%g", there.data_ptr<float>()[0]), "");
}

MaterialMaps moved(MaterialMaps maps, const torch::Device& device) {
  for (Tensor* map : tensors_of(maps)) *map = map->to(device);
  return maps;
}

TEST(FakeDevice, RenderingLossIsTheCpus) {
  const MaterialMaps truth = random_maps(2, 16, 16, torch::kDouble, 1);
  const MaterialMaps prediction = random_maps(2, 16, 16, torch::kDouble, 2);
  const Tensor mask = half_mask(2, 16, torch::kDouble);
  const Loss on_device = [](const MaterialMaps& a, const MaterialMaps& b, const Tensor& m,
                            const std::vector<shading::Light<double>>& lights,
                            const shading::Options& options) {
    return chunked_rendering_loss(moved(a, fake_device()), moved(b, fake_device()), m.to(fake_device()),
                                  lights, options);
  };
  expect_equal(values_of(on_device, prediction, truth, mask, {}),
               values_of(fused_rendering_loss, prediction, truth, mask, {}), 1e-12, 1e-9);
}

/// A run of that many steps with everything that a step can have.
TrainOptions options_of(const TemporaryFolder& folder, Task task, const std::string& run, int64_t steps) {
  TrainOptions o;
  o.task = task;
  o.data = folder / "data";
  o.run = folder / run;
  o.width = 0.125;
  o.size_px = 16;
  o.batch = 2;
  o.steps = steps;
  o.warmup = 0;
  o.threads = 1;
  o.checkpoint_every = 1;
  o.quiet = o.average = o.balanced = o.mirror = o.recolour = true;
  return o;
}

/// "model", "adam.first", ... of a checkpoint's tensor.
std::string kind_of(const std::string& name) {
  return name.substr(0, name.find('.', name.rfind("adam.", 0) == 0 ? 5 : 0));
}

/// How far weights, moments or averages after a step are apart, relatively: the largest of the four.
double distance_of(const std::filesystem::path& run, const std::filesystem::path& wanted, int64_t step) {
  const auto a = read_tensors(checkpoint_file(run, step)).tensors;
  const auto b = read_tensors(checkpoint_file(wanted, step)).tensors;
  EXPECT_EQ(a.size(), b.size());
  std::map<std::string, std::pair<double, double>> squares;
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].first, b[i].first);
    auto& [apart, whole] = squares[kind_of(b[i].first)];
    apart += (a[i].second - b[i].second).to(torch::kDouble).square().sum().item<double>();
    whole += b[i].second.to(torch::kDouble).square().sum().item<double>();
  }
  EXPECT_EQ(squares.size(), 4u);
  double largest = 0;
  for (const auto& [kind, sums] : squares) largest = std::max(largest, std::sqrt(sums.first / sums.second));
  return largest;
}

class FakeDeviceTraining : public testing::TestWithParam<Task> {};

TEST_P(FakeDeviceTraining, GoesAsOnTheCpuAndOnFromIt) {
  const TemporaryFolder folder;
  write_ball_dataset(folder / "data", 2, 2, 16);
  train(options_of(folder, GetParam(), "cpu", 2));
  TrainOptions o = options_of(folder, GetParam(), "fake", 1);
  o.device = fake_device();
  const int64_t before = fake_device_calls();
  EXPECT_EQ(train(o).skipped, 0);
  EXPECT_GT(fake_device_calls() - before, 1000);
  EXPECT_LT(distance_of(folder / "fake", folder / "cpu", 1), 1e-5);
  // The second step from the CPU's checkpoint on the device, and from the device's on the CPU.
  for (const auto& [run, from, device] :
       {std::tuple<const char*, const char*, torch::Device>{"cpu_to_fake", "cpu", fake_device()},
        {"fake_to_cpu", "fake", torch::kCPU}}) {
    o = options_of(folder, GetParam(), run, 2);
    o.device = device;
    o.resume = true;
    std::filesystem::copy(folder / from, folder / run);
    std::filesystem::remove(checkpoint_file(o.run, 2));
    std::filesystem::remove(o.run / kWeightsName);
    EXPECT_EQ(train(o).first_step, 1);
    EXPECT_LT(distance_of(folder / run, folder / "cpu", 2), 1e-5) << run;
  }
}
INSTANTIATE_TEST_SUITE_P(All, FakeDeviceTraining, testing::ValuesIn(kTasks),
                         [](const auto& info) { return std::string(name_of(info.param)); });

TEST(FakeDevice, PriorsGuideWhereTheyAreMovedTo) {
  const TemporaryFolder folder;
  write_ball_dataset(folder / "data", 2, 2, 16);
  std::vector<std::filesystem::path> priors;
  for (const Task task : kPriorTasks)
    priors.push_back(train(options_of(folder, task, name_of(task), 1)).weights);
  for (const auto& device : {torch::Device(torch::kCPU), fake_device()}) {
    TrainOptions o = options_of(folder, Task::kFinetune, device.is_cpu() ? "cpu" : "fake", 1);
    o.guidance = Guidance::kPriors;
    o.priors = priors;
    o.device = device;
    EXPECT_EQ(train(o).skipped, 0);
  }
  EXPECT_LT(distance_of(folder / "fake", folder / "cpu", 1), 1e-5);
}

TEST(FakeDevice, EstimatesAreTheCpus) {
  const TemporaryFolder folder;
  const auto files = weights_in(folder, true);  // trained at 16 px
  torch::manual_seed(1);
  for (const int64_t size : {16, 32}) {
    const Tensor input = network_input(torch::rand({1, 3, size, size}), torch::ones({1, 1, size, size}));
    MaterialMaps here = Estimator(files).estimate(input);
    MaterialMaps there = Estimator(files, PriorsNeeded::kAll, fake_device()).estimate(input);
    for (size_t i = 0; i < 6; ++i) {
      EXPECT_TRUE(tensors_of(there)[i]->device().is_cpu());
      EXPECT_LT(relative_error(*tensors_of(there)[i], *tensors_of(here)[i]), 1e-4) << kMapNames[i];
    }
  }
  const Tensor input = torch::zeros({1, 4, 16, 16});
  const MaterialMaps some = Estimator({files[0]}, PriorsNeeded::kAny, fake_device()).estimate(input);
  EXPECT_TRUE(torch::isfinite(some.normal).all().item<bool>());
  EXPECT_TRUE(torch::isnan(some.sss).all().item<bool>()) << "there is no rss prior";
}

/// As one of two processes: whether both get the sums, on the device.
bool sums_as_rank(int rank, int port) {
  for (const auto& [name, value] : {std::pair<const char*, std::string>{"WORLD_SIZE", "2"},
                                    {"RANK", std::to_string(rank)},
                                    {"MASTER_ADDR", "127.0.0.1"},
                                    {"MASTER_PORT", std::to_string(port)},
                                    {"GLOO_SOCKET_IFNAME", "lo"}})
    ::setenv(name, value.c_str(), 1);
  const Ranks ranks = Ranks::from_environment();
  for (const char* name : {"WORLD_SIZE", "RANK", "MASTER_ADDR", "MASTER_PORT", "GLOO_SOCKET_IFNAME"})
    ::unsetenv(name);
  const Tensor a = torch::full({2, 2}, 1.0 + rank).to(fake_device());
  const Tensor b = torch::full({3}, 10.0 + rank).to(fake_device());
  ranks.sum(std::vector<Tensor>{a, b});
  return a.to(torch::kCPU).equal(torch::full({2, 2}, 3.0)) && b.to(torch::kCPU).equal(torch::full({3}, 21.0));
}

TEST(FakeDevice, RanksSumWhatIsThere) {
  const int port = free_port();
  const pid_t child = ::fork();
  if (child == 0) {
    try {
      ::_exit(sums_as_rank(1, port) ? 0 : 1);
    } catch (const std::exception&) {
      ::_exit(2);
    }
  }
  try {
    EXPECT_TRUE(sums_as_rank(0, port));
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("cannot do"), std::string::npos) << error.what();
    for (const char* name : {"WORLD_SIZE", "RANK", "MASTER_ADDR", "MASTER_PORT", "GLOO_SOCKET_IFNAME"})
      ::unsetenv(name);
    ::waitpid(child, nullptr, 0);
    GTEST_SKIP() << "built without Gloo";
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
}

}  // namespace
}  // namespace ohb
