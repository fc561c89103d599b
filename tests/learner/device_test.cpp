// From the option --device to a device, with and without GPUs.
#include "learner/device.h"

#include <gtest/gtest.h>

#include "test_program.h"
#include "test_samples.h"

namespace ohb {
using namespace learner;
namespace {

const CudaDevices kNoCuda{false, 0}, kNoGpu{true, 0}, kTwo{true, 2};

TEST(Device, IsWhatTheNameAsksFor) {
  for (const CudaDevices& cuda : {kNoCuda, kNoGpu, kTwo}) EXPECT_EQ(device_of("cpu", cuda), torch::kCPU);
  EXPECT_EQ(device_of("auto", kNoCuda), torch::kCPU);
  EXPECT_EQ(device_of("auto", kNoGpu), torch::kCPU);
  EXPECT_EQ(device_of("auto", kTwo), torch::Device(torch::kCUDA, 0));
  EXPECT_EQ(device_of("cuda", kTwo), torch::Device(torch::kCUDA, 0));
  EXPECT_EQ(device_of("cuda:1", kTwo), torch::Device(torch::kCUDA, 1));
}

TEST(Device, SaysWhichPartIsMissing) {
  const auto message = [](const std::string& name, const CudaDevices& cuda) {
    return input_error_of([&] { device_of(name, cuda); });
  };
  expect_message(message("cuda", kNoCuda), {"--device cuda", "built without", "give --device cpu"});
  expect_message(message("cuda:0", kNoGpu), {"--device cuda:0", "libtorch sees none", "give --device cpu"});
  expect_message(message("cuda:2", kTwo), {"--device cuda:2", "sees 2 GPUs", "give --device cpu"});
  for (const char* name : {"", "gpu", "cuda:", "cuda:-1", "cuda:x", "cuda:1x", "cuda:9999", "CPU", "cpu:0"})
    for (const CudaDevices& cuda : {kNoCuda, kTwo})
      expect_message(message(name, cuda), {std::string("--device ") + name, "none of auto, cpu"});
}

TEST(Device, ThatIsNotThereIsBadInputAndOneLine) {
  const TemporaryFolder folder;
  write_ball_dataset(folder / "data", 1, 1, 16);
  const std::vector<std::string> words = {
      "train", "rss",     "--data", folder / "data", "-o", folder / "run", "--width", "0.125", "--size",
      "16",    "--steps", "1",      "--threads",     "1",  "--device"};
  const auto with = [&](const std::string& device) {
    std::vector<std::string> all = words;
    all.push_back(device);
    return run(folder, all);
  };
  for (const char* name : {"cuda:999", "gpu"}) {
    const Result result = with(name);
    EXPECT_EQ(result.code, 2) << result.error;
    EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << result.error;
    EXPECT_NE(result.error.find(std::string("--device ") + name), std::string::npos) << result.error;
    EXPECT_FALSE(std::filesystem::exists(folder / "run"));
  }
  EXPECT_EQ(with("cpu").code, 0);
}

}  // namespace
}  // namespace ohb
