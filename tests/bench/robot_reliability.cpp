#include "tests/bench/robot_reliability.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace ohb {
namespace {

constexpr size_t kBins = 10;
constexpr double kLeastShare = 0.01;  // bins of less area say little

/// E. B. Wilson, "Probable inference, the law of succession, and statistical inference", J. Am. Stat. Assoc.
/// 1927: of what is right of `count` with this share right, at 90 %.
void set_interval(double share, double count, ReliabilityBin& bin) {
  constexpr double kDeviations = 1.645;
  const double z2 = kDeviations * kDeviations / count, middle = (share + z2 / 2) / (1 + z2),
               half = std::sqrt(share * (1 - share) * z2 + z2 * z2 / 4) / (1 + z2);
  bin.low = middle - half;
  bin.high = middle + half;
}

/// Bins that end before these claims; the last has no end.
std::vector<ReliabilityBin> binned(const std::vector<PersonClaims>& people, const std::vector<float>& ends) {
  std::vector<ReliabilityBin> bins(ends.size() + 1);
  std::vector<double> squares(bins.size(), 0);  // of the pieces' areas
  std::set<std::string> names;
  const double count = static_cast<double>(people.size());
  for (const PersonClaims& person : people) {
    names.insert(person.person);
    std::map<std::pair<size_t, uint32_t>, double> pieces;
    for (const Claim& claim : person.claims) {
      const size_t b =
          static_cast<size_t>(std::upper_bound(ends.begin(), ends.end(), claim.claimed) - ends.begin());
      bins[b].area += claim.area / count;
      bins[b].claimed += claim.area / count * claim.claimed;
      bins[b].right += claim.right / count;
      pieces[{b, claim.piece}] += claim.area;
    }
    for (const auto& [key, area] : pieces) {
      bins[key.first].pieces += area >= kLeastOfPiece;
      squares[key.first] += area / count * area / count;
    }
  }
  const double forms = count / static_cast<double>(std::max<size_t>(1, names.size()));
  for (size_t b = 0; b < bins.size(); ++b) {
    if (!(bins[b].area > 0)) continue;
    bins[b].garments = bins[b].area * bins[b].area / squares[b] / forms;
    set_interval(std::min(1.0, bins[b].right / bins[b].area), bins[b].garments, bins[b]);
  }
  return bins;
}

std::string lines_of(const std::vector<ReliabilityBin>& bins) {
  std::string text = "  claimed   right      90 % interval  % of the area  pieces  garments\n";
  for (const ReliabilityBin& bin : bins)
    if (bin.area > 0)
      text += fmt::format("  {:7.3f} {:7.3f}     {:.3f} to {:.3f} {:14.2f} {:7} {:9.1f}\n",
                          bin.claimed / bin.area, bin.right / bin.area, bin.low, bin.high, 100 * bin.area,
                          bin.pieces, bin.garments);
  return text;
}

}  // namespace

std::vector<ReliabilityBin> bins_of_equal_width(const std::vector<PersonClaims>& people) {
  std::vector<float> ends;
  for (size_t b = 1; b < kBins; ++b) ends.push_back(static_cast<float>(b) / kBins);
  return binned(people, ends);
}

std::vector<ReliabilityBin> bins_of_equal_area(const std::vector<PersonClaims>& people) {
  struct Item {
    float claimed;
    double area;
    std::pair<size_t, uint32_t> piece;
  };
  std::vector<Item> items;
  for (size_t p = 0; p < people.size(); ++p)
    for (const Claim& claim : people[p].claims)
      items.push_back({claim.claimed, claim.area, {p, claim.piece}});
  std::sort(items.begin(), items.end(), [](const Item& l, const Item& r) {
    return std::tie(l.claimed, l.piece) < std::tie(r.claimed, r.piece);
  });
  const double target = static_cast<double>(people.size()) / kBins;
  std::vector<float> ends;
  double area = 0;
  std::map<std::pair<size_t, uint32_t>, double> pieces;
  const auto count = [&] {
    return static_cast<size_t>(std::count_if(pieces.begin(), pieces.end(),
                                             [](const auto& of) { return of.second >= kLeastOfPiece; }));
  };
  for (size_t i = 0; i < items.size(); ++i) {
    const bool may_end = i > 0 && items[i].claimed > items[i - 1].claimed;
    if (may_end && area >= target && count() >= kLeastPieces) {
      ends.push_back(items[i].claimed);
      area = 0;
      pieces.clear();
    }
    area += items[i].area;
    pieces[items[i].piece] += items[i].area;
  }
  if (!ends.empty() && (area < target / 2 || count() < kLeastPieces)) ends.pop_back();
  return binned(people, ends);
}

double largest_error(const std::vector<ReliabilityBin>& bins) {
  double worst = 0;
  for (const ReliabilityBin& bin : bins)
    if (bin.area >= kLeastShare) worst = std::max(worst, std::abs(bin.error()));
  return worst;
}

double expected_error(const std::vector<ReliabilityBin>& bins) {
  double sum = 0;
  for (const ReliabilityBin& bin : bins) sum += std::abs(bin.claimed - bin.right);
  return sum;
}

std::string reliability_text(const std::vector<PersonClaims>& people) {
  const std::vector<ReliabilityBin> strict = bins_of_equal_width(people), fair = bins_of_equal_area(people);
  return lines_of(fair) +
         fmt::format(
             "  bins of equal area, {} pieces and more each: largest difference {:.1f} points, expected "
             "calibration error {:.1f}\n",
             kLeastPieces, 100 * largest_error(fair), 100 * expected_error(fair)) +
         lines_of(strict) +
         fmt::format(
             "  bins of equal width, strictly: largest difference of those of 1 % of the area {:.1f} "
             "points, expected calibration error {:.1f}\n",
             100 * largest_error(strict), 100 * expected_error(strict));
}

}  // namespace ohb
