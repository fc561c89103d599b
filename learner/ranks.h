// Several processes, called ranks, that train one network together: each works on its part of every batch,
// and their gradients are summed. c10d with Gloo, over TCP.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "learner/torch.h"

namespace ohb::learner {

class Ranks {
 public:
  /// By RANK, WORLD_SIZE, MASTER_ADDR and MASTER_PORT, as torchrun sets them; one rank alone where WORLD_SIZE
  /// is not set or 1. Waits for the others. The network interface is GLOO_SOCKET_IFNAME, or that of the
  /// host's name. Throws InputError: a variable that is missing or no number, RANK not below WORLD_SIZE, or
  /// several ranks in a build without Gloo. TryAgainError: not all came within five minutes.
  static Ranks from_environment();
  Ranks(Ranks&&) noexcept;
  ~Ranks();

  int rank() const { return rank_; }
  int count() const { return count_; }
  bool is_alone() const { return count_ == 1; }
  bool is_first() const { return rank_ == 0; }

  // All ranks call these in the same order; alone they change nothing. They throw TryAgainError if another
  // rank has ended or has not answered for 50 s.

  /// Sums over the ranks, in place.
  void sum(std::vector<double>& numbers) const;
  /// The same of float32 tensors of one device, in one message; from another device by way of the CPU.
  void sum(const std::vector<torch::Tensor>& tensors) const;
  /// The text that rank 0 gives, on every rank. Once in a run.
  std::string from_first(const std::string& text) const;

 private:
  struct Group;
  Ranks();
  int rank_ = 0, count_ = 1;
  std::unique_ptr<Group> group_;
};

}  // namespace ohb::learner
