#include "learner/ranks.h"

#include <algorithm>
#include <cstdlib>

#include "dataset/model/error.h"

#ifdef USE_C10D_GLOO
#include <torch/csrc/distributed/c10d/ProcessGroupGloo.hpp>
#include <torch/csrc/distributed/c10d/TCPStore.hpp>
#endif

namespace ohb::learner {
namespace {

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

/// A whole number from 0 to `most`.
int number_of(const char* name, int most) {
  const std::string text = variable(name);
  char* end = nullptr;
  const long number = std::strtol(text.c_str(), &end, 10);
  if (text.empty() || *end != '\0' || number < 0 || number > most)
    throw InputError(
        "", name,
        text.empty() ? "is not set" : "is '" + text + "', no whole number up to " + std::to_string(most),
        "set RANK, WORLD_SIZE, MASTER_ADDR and MASTER_PORT for every process, or none of them");
  return static_cast<int>(number);
}

}  // namespace

#ifdef USE_C10D_GLOO

namespace {

constexpr std::chrono::seconds kRendezvous(300), kAnswer(50);

/// What the library says, in one line of moderate length.
std::string words_of(const std::exception& error) {
  std::string words = error.what();
  words = words.substr(0, words.find('\n'));
  return words.size() > 160 ? words.substr(0, 160) + "..." : words;
}

}  // namespace

struct Ranks::Group {
  int rank, count;
  c10::intrusive_ptr<c10d::Store> store;
  c10::intrusive_ptr<c10d::ProcessGroupGloo> gloo;

  /// Runs something that fails if another rank does.
  template <typename Work>
  auto guarded(const Work& work) const {
    try {
      return work();
    } catch (const std::exception& error) {
      throw TryAgainError("rank " + std::to_string(rank) + " of " + std::to_string(count),
                          "another rank has ended or does not answer (" + words_of(error) + ")",
                          "see what the others say, and start all of them again with --resume");
    }
  }

  void sum(torch::Tensor flat) const {
    guarded([&] {
      std::vector<torch::Tensor> tensors = {flat};
      return gloo->allreduce(tensors)->wait();
    });
  }
};

Ranks Ranks::from_environment() {
  Ranks ranks;
  if (variable("WORLD_SIZE").empty()) return ranks;
  ranks.count_ = number_of("WORLD_SIZE", 1 << 16);
  if (ranks.count_ < 1) throw InputError("", "WORLD_SIZE", "is 0", "set it to the number of processes");
  if (ranks.count_ == 1) return ranks;
  ranks.rank_ = number_of("RANK", ranks.count_ - 1);
  const std::string host = variable("MASTER_ADDR");
  if (host.empty()) throw InputError("", "MASTER_ADDR", "is not set", "set it to the host of rank 0");
  c10d::TCPStoreOptions options;
  options.port = static_cast<std::uint16_t>(number_of("MASTER_PORT", 65535));
  options.isServer = ranks.rank_ == 0;
  options.numWorkers = static_cast<std::size_t>(ranks.count_);
  options.timeout = kRendezvous;
  ranks.group_ = std::make_unique<Group>(Group{ranks.rank_, ranks.count_, {}, {}});
  Group& group = *ranks.group_;
  group.guarded([&] {
    group.store = c10::make_intrusive<c10d::TCPStore>(host, options);
    auto gloo = c10d::ProcessGroupGloo::Options::create(kAnswer);
    const std::string interface = variable("GLOO_SOCKET_IFNAME");
    gloo->devices.push_back(interface.empty() ? c10d::ProcessGroupGloo::createDefaultDevice()
                                              : c10d::ProcessGroupGloo::createDeviceForInterface(interface));
    group.gloo = c10::make_intrusive<c10d::ProcessGroupGloo>(group.store, ranks.rank_, ranks.count_, gloo);
    return true;
  });
  return ranks;
}

void Ranks::sum(std::vector<double>& numbers) const {
  if (is_alone()) return;
  group_->sum(torch::from_blob(numbers.data(), {static_cast<int64_t>(numbers.size())}, torch::kDouble));
}

void Ranks::sum(const std::vector<torch::Tensor>& tensors) const {
  if (is_alone() || tensors.empty()) return;
  torch::NoGradGuard no_gradients;
  std::vector<torch::Tensor> flat;
  flat.reserve(tensors.size());
  for (const torch::Tensor& tensor : tensors) flat.push_back(tensor.reshape(-1));
  const torch::Tensor on_cpu = torch::cat(flat).to(torch::kCPU);  // Gloo's
  group_->sum(on_cpu);
  const torch::Tensor joined = on_cpu.to(tensors[0].device());
  int64_t start = 0;
  for (const torch::Tensor& tensor : tensors) {
    tensor.copy_(joined.slice(0, start, start + tensor.numel()).view(tensor.sizes()));
    start += tensor.numel();
  }
}

std::string Ranks::from_first(const std::string& text) const {
  if (is_alone()) return text;
  return group_->guarded([&] {
    if (is_first()) group_->store->set("first", std::vector<uint8_t>(text.begin(), text.end()));
    const std::vector<uint8_t> bytes = group_->store->get("first");
    return std::string(bytes.begin(), bytes.end());
  });
}

#else

struct Ranks::Group {};

Ranks Ranks::from_environment() {
  if (!variable("WORLD_SIZE").empty() && number_of("WORLD_SIZE", 1 << 16) > 1)
    throw InputError("", "WORLD_SIZE", "asks for several processes, which this build cannot do",
                     "install libgloo-dev and build again");
  return {};
}

void Ranks::sum(std::vector<double>&) const {}
void Ranks::sum(const std::vector<torch::Tensor>&) const {}
std::string Ranks::from_first(const std::string& text) const {
  return text;
}

#endif

Ranks::Ranks() = default;
Ranks::Ranks(Ranks&&) noexcept = default;
Ranks::~Ranks() = default;

}  // namespace ohb::learner
