// The networks as TorchScript: what another program gets from the file is what the estimator says.
#include "learner/torchscript.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <torch/script.h>

#include "dataset/model/atomic_file.h"
#include "learner/data.h"
#include "test_program.h"
#include "test_weights.h"

namespace ohb {
using namespace learner;
namespace {

using torch::Tensor;

/// A picture and a mask unlike those that the networks were recorded with.
std::pair<Tensor, Tensor> noise(int64_t batch, int64_t seed) {
  torch::manual_seed(seed);
  const Tensor mask = torch::rand({batch, 1, 16, 16});
  return {torch::rand({batch, 3, 16, 16}) * mask, mask};
}

std::map<std::string, Tensor> read_by_torch(torch::jit::Module module, const Tensor& picture,
                                            const Tensor& mask) {
  std::map<std::string, Tensor> maps;
  for (const auto& item : module.forward({picture, mask}).toGenericDict())
    maps[item.key().toStringRef()] = item.value().toTensor();
  return maps;
}

class TorchScript : public testing::TestWithParam<std::vector<Task>> {};

TEST_P(TorchScript, GivesTheMapsOfTheEstimator) {
  TemporaryFolder folder;
  const Estimator estimator(weights_of(GetParam(), folder));
  const ScriptReport report = write_torchscript(estimator, folder / "estimator.pt");
  EXPECT_EQ(report.size_px, 16);
  int64_t parameters = 0;
  for (const Network& network : estimator.networks())
    for (const Tensor& parameter : network.module().parameters()) parameters += parameter.numel();
  EXPECT_EQ(report.parameters, parameters);
  EXPECT_EQ(estimator.networks().size(), GetParam().size());

  const torch::NoGradGuard no_gradients;
  const torch::jit::Module module = torch::jit::load((folder / "estimator.pt").string());
  for (const int64_t batch : {1, 3}) {
    const auto [picture, mask] = noise(batch, batch);
    const MaterialMaps wanted = estimator.estimate(network_input(picture, mask));
    const std::map<std::string, Tensor> found = read_by_torch(module, picture, mask);
    ASSERT_EQ(found.size(), kMaps.size());
    for (const LearnedMap& map : kMaps) {
      const Tensor& values = wanted.*map.tensor;
      ASSERT_EQ(found.at(map.name).sizes(), values.sizes()) << map.name;
      // Group norm is another kernel there. Normals are divided by lengths of a tenth.
      EXPECT_LT((found.at(map.name) - values).abs().max().item<double>(), 1e-4)
          << map.name << ", batch " << batch;
      EXPECT_GT(values.std().item<double>(), 1e-4) << map.name << " is of one value and tells nothing";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Networks, TorchScript,
                         testing::Values(std::vector{Task::kGeometry, Task::kAlbedo, Task::kRss},
                                         std::vector{Task::kGeometry, Task::kAlbedo, Task::kRss,
                                                     Task::kFinetune},
                                         std::vector{Task::kJoint}),
                         [](const auto& tasks) { return std::string(name_of(tasks.param.back())); });

TEST(TorchScriptFile, SaysWhatItTakesAndHasTheParameters) {
  TemporaryFolder folder;
  const Estimator estimator(weights_in(folder, false));
  write_torchscript(estimator, folder / "estimator.pt");
  torch::jit::ExtraFilesMap extra = {{"humanmaterial.json", ""}};
  const torch::jit::Module module = torch::jit::load((folder / "estimator.pt").string(), c10::nullopt, extra);
  const nlohmann::json json = nlohmann::json::parse(extra.at("humanmaterial.json"));
  EXPECT_EQ(json["size_px"], 16);
  for (const LearnedMap& map : kMaps) EXPECT_TRUE(json["maps"].contains(map.name)) << map.name;
  size_t count = 0;
  for (const Network& network : estimator.networks()) count += network.module().parameters().size();
  EXPECT_EQ(module.parameters().size(), count);
}

TEST(TorchScriptFile, IsTheSameEachTime) {
  TemporaryFolder folder;
  const std::vector<std::filesystem::path> weights = weights_in(folder, false);
  for (const char* name : {"one.pt", "two.pt"}) write_torchscript(Estimator(weights), folder / name);
  EXPECT_EQ(sha256_of_file(folder / "one.pt"), sha256_of_file(folder / "two.pt"));
}

TEST(TorchScriptFile, ComesFromTheProgramOrNotAtAll) {
  TemporaryFolder folder;
  std::vector<std::string> words = {"torchscript", "-o", folder / "estimator.pt", "--json", "--weights"};
  for (const auto& file : weights_in(folder, false)) words.push_back(file.string());
  const Result whole = run(folder, words);
  ASSERT_EQ(whole.code, 0) << whole.error;
  EXPECT_EQ(nlohmann::json::parse(whole.out)["finetuned"], false);
  EXPECT_TRUE(std::filesystem::exists(folder / "estimator.pt"));

  words[2] = folder / "other.pt";
  words.pop_back();
  const Result missing = run(folder, words);
  EXPECT_EQ(missing.code, 2);
  EXPECT_NE(missing.error.find("there is no"), std::string::npos) << missing.error;
  words.push_back((folder / "rss.safetensors").string());
  words[2] = folder / "nowhere/other.pt";
  EXPECT_EQ(run(folder, words).code, 2);
  EXPECT_FALSE(std::filesystem::exists(folder / "other.pt"));
}

TEST(TorchScriptFile, NeverTakesThePlaceOfWhatIsRead) {
  TemporaryFolder folder;
  const std::vector<std::filesystem::path> weights = weights_in(folder, false);
  std::filesystem::create_symlink(weights[2], folder / "link.pt");
  for (const std::filesystem::path& output : {weights[1], folder / "link.pt"}) {
    const std::string before = read_file(output);
    std::vector<std::string> words = {"torchscript", "-o", output, "--weights"};
    words.insert(words.end(), weights.begin(), weights.end());
    const Result result = run(folder, words);
    EXPECT_EQ(result.code, 2);
    EXPECT_NE(result.error.find("is read by this command"), std::string::npos) << result.error;
    EXPECT_EQ(read_file(output), before);
  }
  const std::filesystem::path pipe = folder / "pipe.pt";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const std::filesystem::path& output : {pipe, folder.path()})
    expect_message(input_error_of([&] { write_torchscript(Estimator(weights), output); }),
                   {output.string(), "-o", "a file would be written"});
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
}

}  // namespace
}  // namespace ohb
