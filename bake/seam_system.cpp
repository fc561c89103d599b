#include "bake/seam_system.h"

#include <algorithm>
#include <numeric>

namespace ohb {

template <int kFree, int kColumns>
SeamSystem<kFree, kColumns>::SeamSystem(uint32_t unknowns, const std::vector<Row>& rows)
    : unknowns_(unknowns), place_of_(unknowns), unknown_at_(unknowns) {
  std::iota(place_of_.begin(), place_of_.end(), 0u);
  order(rows);
  for (uint32_t u = 0; u < unknowns_; ++u) unknown_at_[place_of_[u]] = u;
  collect_reads(rows);
  collect_neighbours(rows);
  matrix_.resize(Eigen::Index(kFree) * unknowns_, Eigen::Index(kFree) * unknowns_);
  // Columns of a texel: the lower half of its own block, then whole blocks of those below.
  std::vector<int> row_of;
  int* const outer = matrix_.outerIndexPtr();
  outer[0] = 0;
  for (uint32_t place = 0; place < unknowns_; ++place)
    for (int column = 0; column < kFree; ++column) {
      for (uint32_t n = first_below_[place]; n < first_below_[place + 1]; ++n)
        for (int r = neighbour_[n] == place ? column : 0; r < kFree; ++r)
          row_of.push_back(static_cast<int>(kFree * neighbour_[n]) + r);
      outer[kFree * place + column + 1] = static_cast<int>(row_of.size());
    }
  matrix_.resizeNonZeros(static_cast<Eigen::Index>(row_of.size()));
  std::copy(row_of.begin(), row_of.end(), matrix_.innerIndexPtr());
  std::fill(matrix_.valuePtr(), matrix_.valuePtr() + row_of.size(), 0.0);
  factors_.analyzePattern(matrix_);
  right_.resize(Eigen::Index(kFree) * unknowns_, kColumns);
}

/// Approximate minimum degree (Amestoy, Davis and Duff 1996) on texels, whose numbers stay together.
template <int kFree, int kColumns>
void SeamSystem<kFree, kColumns>::order(const std::vector<Row>& rows) {
  collect_reads(rows);
  collect_neighbours(rows);
  Matrix lower(unknowns_, unknowns_);
  lower.resizeNonZeros(static_cast<Eigen::Index>(neighbour_.size()));
  std::copy(first_below_.begin(), first_below_.end(), lower.outerIndexPtr());
  std::copy(neighbour_.begin(), neighbour_.end(), lower.innerIndexPtr());
  std::fill(lower.valuePtr(), lower.valuePtr() + neighbour_.size(), 1.0);
  const Matrix full = lower.selfadjointView<Eigen::Lower>();
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(full, order);
  for (uint32_t place = 0; place < unknowns_; ++place) place_of_[order.indices()[place]] = place;
}

template <int kFree, int kColumns>
void SeamSystem<kFree, kColumns>::collect_reads(const std::vector<Row>& rows) {
  first_read_.assign(unknowns_ + 1, 0);
  for (const Row& row : rows)
    for (uint32_t unknown : row.unknown)
      if (unknown != kNone) ++first_read_[place_of_[unknown] + 1];
  std::partial_sum(first_read_.begin(), first_read_.end(), first_read_.begin());
  reads_.resize(first_read_.back());
  std::vector<uint32_t> next(first_read_.begin(), first_read_.end() - 1);
  for (uint32_t r = 0; r < rows.size(); ++r)
    for (uint32_t k = 0; k < 8; ++k)
      if (rows[r].unknown[k] != kNone) reads_[next[place_of_[rows[r].unknown[k]]]++] = 8 * r + k;
}

template <int kFree, int kColumns>
void SeamSystem<kFree, kColumns>::collect_neighbours(const std::vector<Row>& rows) {
  std::vector<uint32_t> met_by(unknowns_, kNone);
  first_below_.assign(1, 0);
  neighbour_.clear();
  for (uint32_t place = 0; place < unknowns_; ++place) {
    met_by[place] = place;
    neighbour_.push_back(place);
    for (uint32_t i = first_read_[place]; i < first_read_[place + 1]; ++i)
      for (uint32_t unknown : rows[reads_[i] / 8].unknown) {
        if (unknown == kNone) continue;
        const uint32_t other = place_of_[unknown];
        if (other < place || met_by[other] == place) continue;
        met_by[other] = place;
        neighbour_.push_back(other);
      }
    std::sort(neighbour_.begin() + first_below_.back(), neighbour_.end());
    first_below_.push_back(static_cast<uint32_t>(neighbour_.size()));
  }
}

template <int kFree, int kColumns>
void SeamSystem<kFree, kColumns>::assemble(const std::vector<Row>& rows, const std::vector<Texel>& texels) {
  std::vector<Effect> block(unknowns_, Effect::Zero());  // of the texel in hand and each that it meets
  double* value = matrix_.valuePtr();
  for (uint32_t place = 0; place < unknowns_; ++place) {
    const Texel& texel = texels[unknown_at_[place]];
    Value right = texel.pull;
    for (uint32_t i = first_read_[place]; i < first_read_[place + 1]; ++i) {
      const Row& row = rows[reads_[i] / 8];
      const Effect weighted = row.weight * row.effect[reads_[i] % 8].transpose();
      right -= weighted * row.difference;
      for (int k = 0; k < 8; ++k)
        if (row.unknown[k] != kNone) block[place_of_[row.unknown[k]]] += weighted * row.effect[k];
    }
    block[place].diagonal().array() += texel.hold;
    for (int column = 0; column < kFree; ++column)
      for (uint32_t n = first_below_[place]; n < first_below_[place + 1]; ++n)
        for (int r = neighbour_[n] == place ? column : 0; r < kFree; ++r)
          *value++ = block[neighbour_[n]](column, r);
    for (uint32_t i = first_read_[place]; i < first_read_[place + 1]; ++i)
      for (uint32_t unknown : rows[reads_[i] / 8].unknown)
        if (unknown != kNone) block[place_of_[unknown]].setZero();
    block[place].setZero();
    right_.template middleRows<kFree>(Eigen::Index(kFree) * place) = right;
  }
}

template <int kFree, int kColumns>
auto SeamSystem<kFree, kColumns>::solve(const std::vector<Row>& rows, const std::vector<Texel>& texels)
    -> std::vector<Value> {
  assemble(rows, texels);
  factors_.factorize(matrix_);
  const Eigen::MatrixXd x = factors_.solve(right_);
  std::vector<Value> values(unknowns_);
  for (uint32_t u = 0; u < unknowns_; ++u)
    values[u] = x.template middleRows<kFree>(Eigen::Index(kFree) * place_of_[u]);
  return values;
}

template class SeamSystem<1, 3>;
template class SeamSystem<2, 1>;

}  // namespace ohb
