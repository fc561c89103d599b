#include "dataset/labelling/random_walker.h"

#include <tbb/parallel_for.h>

#include <Eigen/Sparse>
#include <algorithm>
#include <numeric>

namespace ohb::labelling {

using Matrix = Eigen::SparseMatrix<double>;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, kClassCount, Eigen::RowMajor>;
using Value = Eigen::Array<float, kClassCount, 1>;  // all classes are solved side by side
using Sum = Eigen::Array<double, kClassCount, 1>;

namespace {

constexpr float kLeastChange = 2e-4f;
constexpr int kMaxIterations = 2000;
/// Of a node's pairs. What nothing holds, such as faces without area, is singular to a float, and its
/// rounding errors would reach every other node.
constexpr float kLeastHold = 1e-4f;
constexpr size_t kGroupsAtOnce = 128;  // sums are over these, in order: the same for any number of threads
constexpr int kJoins = 6;              // up to 2^6 nodes are a group

/// Joins nodes in pairs, those first whose pairs weigh most, kJoins times. Gives each node's group.
std::vector<uint32_t> group_nodes(size_t nodes, std::vector<EnergyPair> pairs, uint32_t& groups) {
  std::vector<uint32_t> group_of(nodes);
  std::iota(group_of.begin(), group_of.end(), 0u);
  groups = static_cast<uint32_t>(nodes);
  constexpr uint32_t kNone = 0xffffffffu;
  for (int join = 0; join < kJoins; ++join) {
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const EnergyPair& l, const EnergyPair& r) { return l.weight > r.weight; });
    std::vector<uint32_t> next(groups, kNone);
    uint32_t count = 0;
    for (const EnergyPair& pair : pairs)
      if (next[pair.a] == kNone && next[pair.b] == kNone) next[pair.a] = next[pair.b] = count++;
    for (uint32_t& group : next)
      if (group == kNone) group = count++;
    for (uint32_t& group : group_of) group = next[group];
    for (EnergyPair& pair : pairs) {
      pair.a = next[pair.a];
      pair.b = next[pair.b];
      if (pair.a > pair.b) std::swap(pair.a, pair.b);
    }
    std::stable_sort(pairs.begin(), pairs.end(), [](const EnergyPair& l, const EnergyPair& r) {
      return std::pair(l.a, l.b) < std::pair(r.a, r.b);
    });
    size_t kept = 0;
    for (const EnergyPair& pair : pairs) {
      if (pair.a == pair.b) continue;
      if (kept > 0 && pairs[kept - 1].a == pair.a && pairs[kept - 1].b == pair.b)
        pairs[kept - 1].weight += pair.weight;
      else
        pairs[kept++] = pair;
    }
    pairs.resize(kept);
    groups = count;
  }
  return group_of;
}

Value ratio(const Sum& a, const Sum& b) {
  return (b > 0).select(a / b, Sum::Zero()).cast<float>();
}

}  // namespace

/// The walk's matrix by rows, and the same summed over groups of nodes. Nodes are numbered by their groups.
struct RandomWalker::Matrices {
  struct Entry {
    uint32_t to;
    float weight;
  };
  std::vector<uint32_t> number_of;  // of the caller's nodes
  std::vector<uint32_t> first;      // of a row's entries beside the diagonal
  std::vector<Entry> entries;
  std::vector<float> diagonal, restart;
  std::vector<uint32_t> first_of_group;
  Matrix coarse;

  size_t size() const { return restart.size(); }
};

namespace {

/// Conjugate gradients, preconditioned by the diagonal and by the groups' exact solution.
class Solve {
 public:
  /// Solves (walk + diag(held)) x = right, from the x that is there.
  Solve(const RandomWalker::Matrices& walk, const std::vector<float>& held, std::vector<Value> right,
        std::vector<Value>& x)
      : walk_(walk),
        first_of_group_(walk.first_of_group),
        blocks_((first_of_group_.size() + kGroupsAtOnce - 2) / kGroupsAtOnce),
        diagonal_(walk.diagonal),
        residual_(std::move(right)),
        along_(x.size()),
        direction_(x.size(), Value::Zero()),
        x_(x) {
    Matrix coarse = walk.coarse;
    for (Eigen::Index g = 0; g < coarse.rows(); ++g)
      for (uint32_t n = first_of_group_[g]; n < first_of_group_[g + 1]; ++n)
        if (held[n] > 0) coarse.coeffRef(g, g) += held[n];
    factors_.compute(coarse);
    grouped_.resize(coarse.rows(), kClassCount);
    for (size_t n = 0; n < held.size(); ++n) diagonal_[n] += held[n];
    for (float d : diagonal_) inverse_.push_back(1 / d);
  }

  void run() {
    multiply(x_);
    Sum product = descend(Value::Zero(), Value::Ones());
    float largest = aim(Value::Zero());
    for (int i = 0; i < kMaxIterations && largest > kLeastChange; ++i) {
      const Value way = ratio(product, multiply(direction_));
      const Sum next = descend(way, way);
      largest = aim(ratio(next, product));
      product = next;
    }
  }

 private:
  /// Runs visit(group, first node, end node, result) for all groups, those of a block with the same result,
  /// and gives the results of the blocks.
  template <typename Visit>
  std::vector<Sum> each_group(const Visit& visit) const {
    std::vector<Sum> results(blocks_, Sum::Zero());
    tbb::parallel_for(size_t{0}, blocks_, [&](size_t b) {
      const size_t end = std::min((b + 1) * kGroupsAtOnce, first_of_group_.size() - 1);
      for (size_t g = b * kGroupsAtOnce; g < end; ++g)
        visit(static_cast<Eigen::Index>(g), first_of_group_[g], first_of_group_[g + 1], results[b]);
    });
    return results;
  }
  static Sum total(const std::vector<Sum>& sums) {
    return std::accumulate(sums.begin(), sums.end(), Sum(Sum::Zero()));
  }
  /// along = matrix v. Gives v along.
  Sum multiply(const std::vector<Value>& v) {
    return total(each_group([&](Eigen::Index, uint32_t begin, uint32_t end, Sum& sum) {
      Value product = Value::Zero();
      for (uint32_t n = begin; n < end; ++n) {
        Value row = diagonal_[n] * v[n];
        for (uint32_t e = walk_.first[n]; e < walk_.first[n + 1]; ++e)
          row -= walk_.entries[e].weight * v[walk_.entries[e].to];
        along_[n] = row;
        product += v[n] * row;
      }
      sum += product.cast<double>();
    }));
  }
  /// x += way direction, residual -= along_way along; solves the groups. Gives the product of the residual
  /// and the preconditioner's answer to it.
  Sum descend(const Value& way, const Value& along_way) {
    const Sum of_nodes = total(each_group([&](Eigen::Index g, uint32_t begin, uint32_t end, Sum& sum) {
      Value of_group = Value::Zero(), product = Value::Zero();
      for (uint32_t n = begin; n < end; ++n) {
        x_[n] += way * direction_[n];
        const Value residual = residual_[n] - along_way * along_[n];
        residual_[n] = residual;
        of_group += residual;
        product += residual * residual * inverse_[n];
      }
      grouped_.row(g) = of_group.matrix().transpose().cast<double>();
      sum += product.cast<double>();
    }));
    of_groups_ = factors_.solve(grouped_);
    return of_nodes + grouped_.cwiseProduct(of_groups_).colwise().sum().transpose().array();
  }
  /// direction = the preconditioner's answer + back direction. Gives the largest value of the answer.
  float aim(const Value& back) {
    const auto largest = each_group([&](Eigen::Index g, uint32_t begin, uint32_t end, Sum& most) {
      const Value of_group = of_groups_.row(g).transpose().array().cast<float>();
      Value high = most.cast<float>();
      for (uint32_t n = begin; n < end; ++n) {
        const Value step = residual_[n] * inverse_[n] + of_group;
        high = high.max(step.abs());
        direction_[n] = step + back * direction_[n];
      }
      most = high.cast<double>();
    });
    double most = 0;
    for (const Sum& of_block : largest) most = std::max(most, of_block.maxCoeff());
    return static_cast<float>(most);
  }

  const RandomWalker::Matrices& walk_;
  const std::vector<uint32_t>& first_of_group_;
  const size_t blocks_;
  Eigen::SimplicialLDLT<Matrix> factors_;
  std::vector<float> diagonal_, inverse_;
  std::vector<Value> residual_, along_, direction_;
  std::vector<Value>& x_;
  Rows grouped_, of_groups_;
};

}  // namespace

RandomWalker::RandomWalker(size_t nodes, const std::vector<EnergyPair>& conductance,
                           std::vector<float> restart)
    : matrices_(std::make_unique<Matrices>()) {
  Matrices& m = *matrices_;
  std::vector<float> pairs(nodes, 0);
  for (const EnergyPair& pair : conductance)
    for (uint32_t node : {pair.a, pair.b}) pairs[node] += pair.weight;
  for (size_t n = 0; n < nodes; ++n) restart[n] = std::max(restart[n], kLeastHold * pairs[n]);
  uint32_t groups = 0;
  const std::vector<uint32_t> group_of = group_nodes(nodes, conductance, groups);
  m.first_of_group.assign(groups + 1, 0);
  for (uint32_t group : group_of) ++m.first_of_group[group + 1];
  std::partial_sum(m.first_of_group.begin(), m.first_of_group.end(), m.first_of_group.begin());
  std::vector<uint32_t> next(m.first_of_group.begin(), m.first_of_group.end() - 1);
  for (uint32_t group : group_of) m.number_of.push_back(next[group]++);
  m.restart.resize(nodes);
  for (size_t n = 0; n < nodes; ++n) m.restart[m.number_of[n]] = restart[n];
  m.diagonal = m.restart;
  m.first.assign(nodes + 1, 0);
  std::vector<Eigen::Triplet<double, int>> coarse;
  for (size_t n = 0; n < nodes; ++n) coarse.emplace_back(group_of[n], group_of[n], restart[n]);
  for (const EnergyPair& pair : conductance) {
    for (const auto& [from, to] : {std::pair(pair.a, pair.b), std::pair(pair.b, pair.a)}) {
      m.diagonal[m.number_of[from]] += pair.weight;
      ++m.first[m.number_of[from] + 1];
      coarse.emplace_back(group_of[from], group_of[from], pair.weight);
      coarse.emplace_back(group_of[from], group_of[to], -pair.weight);
    }
  }
  m.coarse.resize(groups, groups);
  m.coarse.setFromTriplets(coarse.begin(), coarse.end());
  std::partial_sum(m.first.begin(), m.first.end(), m.first.begin());
  next.assign(m.first.begin(), m.first.end() - 1);
  m.entries.resize(2 * conductance.size());
  for (const EnergyPair& pair : conductance) {
    const uint32_t a = m.number_of[pair.a], b = m.number_of[pair.b];
    m.entries[next[a]++] = {b, pair.weight};
    m.entries[next[b]++] = {a, pair.weight};
  }
}

RandomWalker::~RandomWalker() = default;

std::vector<ClassValues> RandomWalker::solve(const std::vector<ClassValues>& start,
                                             const std::vector<Seed>& seeds,
                                             const std::vector<ClassValues>& guess) const {
  const Matrices& m = *matrices_;
  const auto value_of = [](const ClassValues& v) -> Value { return Eigen::Map<const Value>(v.data()); };
  std::vector<float> held(m.size(), 0);
  std::vector<Value> right(m.size()), solution(m.size());
  for (size_t n = 0; n < m.size(); ++n) {
    const uint32_t number = m.number_of[n];
    right[number] = m.restart[number] * value_of(start[n]);
    solution[number] = value_of((guess.empty() ? start : guess)[n]);
  }
  for (const Seed& seed : seeds) {
    held[m.number_of[seed.face]] += seed.conductance;
    right[m.number_of[seed.face]][seed.material_class] += seed.conductance;
  }
  Solve(m, held, std::move(right), solution).run();
  std::vector<ClassValues> values(m.size());
  for (size_t n = 0; n < values.size(); ++n) {
    float left = 1;  // the last class is what the others leave
    for (int c = 0; c + 1 < kClassCount; ++c) {
      values[n][c] = std::clamp(solution[m.number_of[n]][c], 0.0f, left);
      left -= values[n][c];
    }
    values[n][kClassCount - 1] = left;
  }
  return values;
}

}  // namespace ohb::labelling
