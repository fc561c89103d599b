// The least change of some texels that brings the two sides of seams together: a sparse linear system.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace ohb::bake {

/// Unknowns are changes of texels, each of kFree numbers in kColumns independent columns (a colour: one
/// number in three columns that share a matrix; a direction: two numbers in one). solve() gives the x that
/// makes
///   sum over texels of hold |x|^2 - 2 x . pull  +  sum over rows of weight |difference + sum effect x|^2
/// least, by a Cholesky factorisation; one thread, so the bits are always the same.
template <int kFree, int kColumns>
class SeamSystem {
 public:
  using Effect = std::array<double, kFree * kFree>;    // kFree rows
  using Value = std::array<double, kFree * kColumns>;  // kFree rows
  static constexpr uint32_t kNone = 0xffffffffu;
  struct Row {
    std::array<uint32_t, 8> unknown;  // kNone: a texel that keeps its value
    std::array<Effect, 8> effect;     // of a change of the unknown on the difference
    Value difference;
    double weight;
  };
  struct Texel {
    double hold;
    Value pull;
  };

  /// Which unknown meets which; `rows` of solve() must have the same.
  SeamSystem(uint32_t unknowns, const std::vector<Row>& rows);
  ~SeamSystem();
  std::vector<Value> solve(const std::vector<Row>& rows, const std::vector<Texel>& texels);

 private:
  struct Factors;
  void collect_reads(const std::vector<Row>& rows);
  void collect_neighbours(const std::vector<Row>& rows);
  void order(const std::vector<Row>& rows);
  void lay_out();
  void assemble(const std::vector<Row>& rows, const std::vector<Texel>& texels);
  /// Adds what a row says of one of its unknowns to the blocks beside it and to its right side.
  void add_row(const Row& row, uint32_t which, Value& right);

  uint32_t unknowns_;
  std::vector<uint32_t> place_of_, unknown_at_;    // in the order of elimination
  std::vector<uint32_t> first_read_, reads_;       // of each place: 8 x row + which of its unknowns
  std::vector<uint32_t> first_below_, neighbour_;  // of each place: itself and later ones that it meets
  std::vector<Effect> blocks_;                     // of the place in hand with each that it meets
  std::unique_ptr<Factors> factors_;
};

extern template class SeamSystem<1, 3>;
extern template class SeamSystem<2, 1>;

}  // namespace ohb::bake
