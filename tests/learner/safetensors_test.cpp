// Tensor files: round trips, and files that lie.
#include "learner/safetensors.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "dataset/model/atomic_file.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace learner;
namespace {

TensorFile example() {
  return {{{"a.weight", torch::rand({3, 4, 1})},
           {"b", torch::rand({5}).to(torch::kHalf)},
           {"empty", torch::zeros({0, 2})},
           {"step", torch::tensor({int64_t{7}})}},
          {{"format", "test"}, {"text", "with \"quotes\""}}};
}

std::string with_header(const std::string& header, const std::string& data) {
  const uint64_t length = header.size();
  return std::string(reinterpret_cast<const char*>(&length), 8) + header + data;
}

TEST(TensorFile, ComesBackBitForBit) {
  TemporaryFolder folder;
  const TensorFile written = example();
  write_tensors(folder / "x.safetensors", written);
  const TensorFile read = read_tensors(folder / "x.safetensors");
  EXPECT_EQ(read.metadata, written.metadata);
  ASSERT_EQ(read.tensors.size(), written.tensors.size());
  for (const auto& [name, tensor] : written.tensors) {
    bool found = false;
    for (const auto& [other, same] : read.tensors)
      if (other == name) found = same.scalar_type() == tensor.scalar_type() && same.equal(tensor);
    EXPECT_TRUE(found) << name;
  }
}

TEST(TensorFile, EveryTruncationIsRefused) {
  TemporaryFolder folder;
  write_tensors(folder / "x", example());
  const std::string bytes = read_file(folder / "x");
  for (size_t length = 0; length < bytes.size(); length += length < 600 ? 7 : 31) {
    std::ofstream(folder / "y", std::ios::binary) << bytes.substr(0, length);
    expect_message(input_error_of([&] { read_tensors(folder / "y"); }), {"y"});
  }
  std::ofstream(folder / "y", std::ios::binary) << bytes << "more";
  expect_message(input_error_of([&] { read_tensors(folder / "y"); }), {"belong to no tensor"});
}

TEST(TensorFile, HostileHeadersAreRefused) {
  TemporaryFolder folder;
  const std::string huge = "9223372036854775807";
  const std::vector<std::string> files = {
      std::string(8, '\xff'),
      with_header("", ""),
      with_header("[]", ""),
      with_header("{", ""),
      with_header(std::string(100000, '['), ""),
      with_header(std::string(50000, '{'), ""),
      with_header(R"({"a":1})", ""),
      with_header(R"({"a":{"dtype":"F64","shape":[1],"data_offsets":[0,8]}})", std::string(8, 0)),
      with_header(R"({"a":{"dtype":"F32","shape":[1],"data_offsets":[0,8]}})", std::string(8, 0)),
      with_header(R"({"a":{"dtype":"F32","shape":[-1],"data_offsets":[0,4]}})", std::string(4, 0)),
      with_header(R"({"a":{"dtype":"F32","shape":[1.5],"data_offsets":[0,4]}})", std::string(4, 0)),
      with_header(R"({"a":{"dtype":"F32","shape":[)" + huge + "," + huge + R"(],"data_offsets":[0,4]}})",
                  std::string(4, 0)),
      with_header(R"({"a":{"dtype":"F32","shape":[1],"data_offsets":[4,0]}})", std::string(4, 0)),
      with_header(R"({"a":{"dtype":"F32","shape":[1],"data_offsets":[)" + huge + "," + huge + R"(]}})",
                  std::string(4, 0)),
      with_header(R"({"a":{"dtype":"F32","shape":[1],"data_offsets":["0","4"]}})", std::string(4, 0)),
      with_header(
          R"({"a":{"dtype":"F32","shape":[1],"data_offsets":[0,4]},"b":{"dtype":"F32","shape":[1],"data_offsets":[0,4]}})",
          std::string(4, 0)),
      with_header(R"({"a":{"dtype":"F32","shape":[1],"data_offsets":[4,8]}})", std::string(8, 0)),
      with_header(R"({"__metadata__":{"x":1}})", ""),
      with_header(R"({"__metadata__":"x"})", ""),
      with_header(R"({"a":{"dtype":"F32","shape":[1,1,1,1,1,1,1,1,1],"data_offsets":[0,4]}})",
                  std::string(4, 0)),
  };
  for (size_t i = 0; i < files.size(); ++i) {
    SCOPED_TRACE(i);
    std::ofstream(folder / "x", std::ios::binary) << files[i];
    EXPECT_NE(input_error_of([&] { read_tensors(folder / "x"); }), "");
  }
}

TEST(TensorFile, EveryFlippedByteIsReadOrRefusedNeverWorse) {
  TemporaryFolder folder;
  write_tensors(folder / "x", example());
  const std::string bytes = read_file(folder / "x");
  for (size_t i = 0; i < std::min<size_t>(bytes.size(), 420); ++i)
    for (const char flip : {1, 16, -128}) {
      std::string broken = bytes;
      broken[i] = static_cast<char>(broken[i] ^ flip);
      std::ofstream(folder / "y", std::ios::binary) << broken;
      try {
        read_tensors(folder / "y");
      } catch (const InputError&) {
      }
    }
}

}  // namespace
}  // namespace ohb
