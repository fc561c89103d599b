#include "bake/seam_system.h"

#include <Eigen/Sparse>
#include <algorithm>
#include <numeric>

namespace ohb::bake {

using Matrix = Eigen::SparseMatrix<double>;

template <int kFree, int kColumns>
struct SeamSystem<kFree, kColumns>::Factors {
  Matrix matrix;  // lower half
  Eigen::MatrixXd right;
  Eigen::SimplicialLDLT<Matrix, Eigen::Lower, Eigen::NaturalOrdering<int>> factors;
};

template <int kFree, int kColumns>
SeamSystem<kFree, kColumns>::SeamSystem(uint32_t unknowns, const std::vector<Row>& rows)
    : unknowns_(unknowns),
      place_of_(unknowns),
      unknown_at_(unknowns),
      blocks_(unknowns),
      factors_(std::make_unique<Factors>()) {
  std::iota(place_of_.begin(), place_of_.end(), 0u);
  order(rows);
  for (uint32_t u = 0; u < unknowns_; ++u) unknown_at_[place_of_[u]] = u;
  collect_reads(rows);
  collect_neighbours(rows);
  lay_out();
}

template <int kFree, int kColumns>
SeamSystem<kFree, kColumns>::~SeamSystem() = default;

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

/// Columns of a texel: the lower half of its own block, then whole blocks of those below.
template <int kFree, int kColumns>
void SeamSystem<kFree, kColumns>::lay_out() {
  Matrix& matrix = factors_->matrix;
  matrix.resize(Eigen::Index(kFree) * unknowns_, Eigen::Index(kFree) * unknowns_);
  std::vector<int> row_of;
  int* const outer = matrix.outerIndexPtr();
  outer[0] = 0;
  for (uint32_t place = 0; place < unknowns_; ++place)
    for (int column = 0; column < kFree; ++column) {
      for (uint32_t n = first_below_[place]; n < first_below_[place + 1]; ++n)
        for (int r = neighbour_[n] == place ? column : 0; r < kFree; ++r)
          row_of.push_back(static_cast<int>(kFree * neighbour_[n]) + r);
      outer[kFree * place + column + 1] = static_cast<int>(row_of.size());
    }
  matrix.resizeNonZeros(static_cast<Eigen::Index>(row_of.size()));
  std::copy(row_of.begin(), row_of.end(), matrix.innerIndexPtr());
  std::fill(matrix.valuePtr(), matrix.valuePtr() + row_of.size(), 0.0);
  factors_->factors.analyzePattern(matrix);
  factors_->right.resize(Eigen::Index(kFree) * unknowns_, kColumns);
}

template <int kFree, int kColumns>
void SeamSystem<kFree, kColumns>::add_row(const Row& row, uint32_t which, Value& right) {
  Effect turned;  // weight x effect, transposed
  for (int a = 0; a < kFree; ++a)
    for (int b = 0; b < kFree; ++b) turned[a * kFree + b] = row.weight * row.effect[which][b * kFree + a];
  for (int a = 0; a < kFree; ++a)
    for (int column = 0; column < kColumns; ++column)
      for (int b = 0; b < kFree; ++b)
        right[a * kColumns + column] -= turned[a * kFree + b] * row.difference[b * kColumns + column];
  for (int k = 0; k < 8; ++k) {
    if (row.unknown[k] == kNone) continue;
    Effect& block = blocks_[place_of_[row.unknown[k]]];
    for (int a = 0; a < kFree; ++a)
      for (int c = 0; c < kFree; ++c)
        for (int b = 0; b < kFree; ++b)
          block[a * kFree + c] += turned[a * kFree + b] * row.effect[k][b * kFree + c];
  }
}

template <int kFree, int kColumns>
void SeamSystem<kFree, kColumns>::assemble(const std::vector<Row>& rows, const std::vector<Texel>& texels) {
  double* value = factors_->matrix.valuePtr();
  for (uint32_t place = 0; place < unknowns_; ++place) {
    const uint32_t first = first_below_[place], end = first_below_[place + 1];
    for (uint32_t n = first; n < end; ++n) blocks_[neighbour_[n]].fill(0);
    const Texel& texel = texels[unknown_at_[place]];
    Value right = texel.pull;
    for (uint32_t i = first_read_[place]; i < first_read_[place + 1]; ++i)
      add_row(rows[reads_[i] / 8], reads_[i] % 8, right);
    for (int a = 0; a < kFree; ++a) blocks_[place][a * kFree + a] += texel.hold;
    for (int column = 0; column < kFree; ++column)
      for (uint32_t n = first; n < end; ++n)
        for (int r = neighbour_[n] == place ? column : 0; r < kFree; ++r)
          *value++ = blocks_[neighbour_[n]][column * kFree + r];
    for (int a = 0; a < kFree; ++a)
      for (int column = 0; column < kColumns; ++column)
        factors_->right(Eigen::Index(kFree) * place + a, column) = right[a * kColumns + column];
  }
}

template <int kFree, int kColumns>
auto SeamSystem<kFree, kColumns>::solve(const std::vector<Row>& rows, const std::vector<Texel>& texels)
    -> std::vector<Value> {
  assemble(rows, texels);
  factors_->factors.factorize(factors_->matrix);
  const Eigen::MatrixXd x = factors_->factors.solve(factors_->right);
  std::vector<Value> values(unknowns_);
  for (uint32_t u = 0; u < unknowns_; ++u)
    for (int a = 0; a < kFree; ++a)
      for (int column = 0; column < kColumns; ++column)
        values[u][a * kColumns + column] = x(Eigen::Index(kFree) * place_of_[u] + a, column);
  return values;
}

template class SeamSystem<1, 3>;
template class SeamSystem<2, 1>;

}  // namespace ohb::bake
