#include "dataset/labelling/random_walker.h"

#include <tbb/parallel_for.h>

#include <Eigen/Sparse>
#include <algorithm>

namespace ohb {

using Matrix = Eigen::SparseMatrix<float, Eigen::RowMajor, int>;
using Vector = Eigen::VectorXf;

struct RandomWalker::Matrices {
  Matrix walk;  // L + R
  Vector restart;
};

namespace {

constexpr float kLeastChange = 1e-4f;
constexpr int kMaxIterations = 2000;

Vector column_of(const std::vector<ClassValues>& values, int c) {
  Vector column(static_cast<Eigen::Index>(values.size()));
  for (size_t n = 0; n < values.size(); ++n) column[static_cast<Eigen::Index>(n)] = values[n][c];
  return column;
}

/// Solves (walk + diag(held)) x = right, from the x that is there.
void conjugate_gradients(const Matrix& walk, const Vector& held, const Vector& right, Vector& x) {
  const Vector inverse = (walk.diagonal() + held).cwiseInverse();
  Vector along = walk * x;
  Vector residual = right - along - held.cwiseProduct(x);
  Vector step = residual.cwiseProduct(inverse), direction = step;
  double product = residual.cast<double>().dot(step.cast<double>());
  for (int i = 0; i < kMaxIterations && step.lpNorm<Eigen::Infinity>() > kLeastChange; ++i) {
    along.noalias() = walk * direction;
    along += held.cwiseProduct(direction);
    const auto length = static_cast<float>(product / direction.cast<double>().dot(along.cast<double>()));
    x += length * direction;
    residual -= length * along;
    step = residual.cwiseProduct(inverse);
    const double next = residual.cast<double>().dot(step.cast<double>());
    direction = step + static_cast<float>(next / product) * direction;
    product = next;
  }
}

}  // namespace

RandomWalker::RandomWalker(size_t nodes, const std::vector<EnergyPair>& conductance,
                           std::vector<float> restart)
    : matrices_(std::make_unique<Matrices>()) {
  std::vector<Eigen::Triplet<float, int>> entries;
  entries.reserve(4 * conductance.size() + nodes);
  for (const EnergyPair& pair : conductance) {
    const int a = static_cast<int>(pair.a), b = static_cast<int>(pair.b);
    entries.emplace_back(a, a, pair.weight);
    entries.emplace_back(b, b, pair.weight);
    entries.emplace_back(a, b, -pair.weight);
    entries.emplace_back(b, a, -pair.weight);
  }
  for (int n = 0; n < static_cast<int>(nodes); ++n) entries.emplace_back(n, n, restart[n]);
  const int size = static_cast<int>(nodes);
  matrices_->walk.resize(size, size);
  matrices_->walk.setFromTriplets(entries.begin(), entries.end());
  matrices_->restart = Eigen::Map<const Vector>(restart.data(), size);
}

RandomWalker::~RandomWalker() = default;

std::vector<ClassValues> RandomWalker::solve(const std::vector<ClassValues>& start,
                                             const std::vector<Seed>& seeds,
                                             const std::vector<ClassValues>& guess) const {
  Vector held = Vector::Zero(static_cast<Eigen::Index>(start.size()));
  for (const Seed& seed : seeds) held[seed.face] += seed.conductance;
  std::vector<Vector> solution(kClassCount - 1);  // the last class is what the others leave
  tbb::parallel_for(0, kClassCount - 1, [&](int c) {
    Vector right = matrices_->restart.cwiseProduct(column_of(start, c));
    for (const Seed& seed : seeds)
      if (seed.material_class == c) right[seed.face] += seed.conductance;
    solution[c] = column_of(guess.empty() ? start : guess, c);
    conjugate_gradients(matrices_->walk, held, right, solution[c]);
  });
  std::vector<ClassValues> values(start.size());
  for (size_t n = 0; n < values.size(); ++n) {
    float left = 1;
    for (int c = 0; c + 1 < kClassCount; ++c) {
      values[n][c] = std::clamp(solution[c][static_cast<Eigen::Index>(n)], 0.0f, left);
      left -= values[n][c];
    }
    values[n][kClassCount - 1] = left;
  }
  return values;
}

}  // namespace ohb
