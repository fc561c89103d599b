// The learner's files under random damage: tensor files, and the checkpoints and weights in them. Settings as
// in fuzz_test.cpp.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "dataset/model/atomic_file.h"
#include "learner/checkpoint.h"
#include "learner/safetensors.h"
#include "tests/fuzz/mutate.h"
#include "tests/support/scan_files.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace learner;
namespace {

size_t number_in(const char* variable, size_t otherwise) {
  const char* text = std::getenv(variable);
  return text ? std::strtoull(text, nullptr, 10) : otherwise;
}

/// Weights of the smallest network, as train writes them.
std::filesystem::path small_weights(const TemporaryFolder& folder) {
  const nlohmann::json header = {
      {"format", kCheckpointFormat}, {"task", "geometry"}, {"width", 0.01}, {"size_px", 16}, {"step", 3},
      {"people", {"a", "b"}}};
  save_weights(folder / "w.safetensors", header, make_network(task_from_name("geometry"), 0.01));
  return folder / "w.safetensors";
}

/// The length of the header is put right every other time, so that its JSON is reached.
std::string damaged(const std::string& whole, std::mt19937& random) {
  uint64_t length = 0;
  std::memcpy(&length, whole.data(), sizeof length);
  std::string header = whole.substr(sizeof length, length), data = whole.substr(sizeof length + length);
  if (random() % 4 == 0) return mutated(whole, random);
  std::string& part = random() % 4 ? header : data;
  part = mutated(part, random);
  length = header.size();
  return std::string(reinterpret_cast<const char*>(&length), sizeof length) + header + data;
}

TEST(FuzzWeights, AreReadOrRefused) {
  const TemporaryFolder folder;
  const std::string whole = read_file(small_weights(folder));
  load_network(folder / "w.safetensors");
  size_t read = 0, refused = 0;
  const size_t inputs = number_in("OHB_FUZZ_INPUTS", 800) / 10;
  for (size_t i = 0; i < inputs; ++i) {
    std::mt19937 random(static_cast<uint32_t>(i * 7919 + number_in("OHB_FUZZ_SEED", 1)));
    const auto file = write_bytes(folder / "damaged.safetensors", damaged(whole, random));
    if (const char* journal = std::getenv("OHB_FUZZ_JOURNAL"))
      write_bytes(journal, "Weights:" + std::to_string(i) + "\n");
    for (const bool whole_network : {false, true}) try {
        whole_network ? (void)load_network(file) : (void)read_tensors(file);
        ++read;
      } catch (const InputError& error) {
        ++refused;
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
      } catch (const std::exception& error) {
        ADD_FAILURE() << "Weights:" << i << ": " << error.what();
      }
  }
  std::printf("%-16s %5zu read, %5zu refused\n", "Weights", read, refused);
  EXPECT_GT(refused, 0u);
}

}  // namespace
}  // namespace ohb
