#include "renderer/render_to_error.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "renderer/budget.h"
#include "renderer/error_regions.h"

namespace ohb::renderer {
namespace {

constexpr int kPilots = 4, kStreams = 4;
// Pilots take an eighth of the forecast work, within these limits.
constexpr int kLeastPilotSpp = 1, kMostPilotSpp = 16, kPilotShare = 8;
constexpr uint64_t kStreamSeeds = 0x73747265616dull;
constexpr double kFirstShare = 0.25, kGrowth = 1.12;  // of the forecast; from round to round
// Before the first look at the error: fewer tell it so badly that images stop by luck, and report less error
// than they have (a sixth less of a lamp's highlights at a goal that a dozen paths reach).
constexpr double kFirstLookSpp = 10;
constexpr double kBudgetScale = 4096;  // adaptive_budget rounds to whole paths
constexpr double kLeastFactor = 1.0 / 16;

double square(double x) {
  return x * x;
}

/// What pilots tell: expected square, and the variance of one path, at every value of a light's image.
class PilotValues {
 public:
  PilotValues(const std::vector<std::vector<SampleLight>>& pilots, int spp) : pilots_(pilots), spp_(spp) {}
  RegionSums operator()(size_t light, size_t i) const {
    double sum = 0, squares = 0;
    for (const std::vector<SampleLight>& pilot : pilots_) {
      const double v = pilot[light].radiance.values[i];
      sum += v, squares += v * v;
    }
    const double n = static_cast<double>(pilots_.size());
    const double variance = std::max(0.0, squares - sum * sum / n) / (n - 1);
    return {square(sum / n) - variance / n, variance * spp_};
  }

 private:
  const std::vector<std::vector<SampleLight>>& pilots_;
  double spp_;
};

/// Paths of each pixel that bring every region to the goal, by what the pilots say.
struct Forecast {
  std::vector<double> paths;
  double mean_spp = 0;
};

class ErrorRender {
 public:
  ErrorRender(const Picture& picture, const ErrorGoal& goal, RenderStatistics& statistics,
              const PixelsDone& done, const RoundDone& round_done)
      : picture_(picture),
        goal_(goal),
        statistics_(statistics),
        done_(done),
        round_done_(round_done),
        regions_(error_regions(picture)),
        light_count_(picture.context.lights.size()) {}

  std::vector<SampleLight> run(ErrorReport& report) {
    const uint64_t paths_before = statistics_.paths;
    std::vector<SampleLight> image = regions_.pixels[0] > 0 ? converge(report.met) : nothing(report.met);
    if (regions_.pixels[0] > 0)
      report.spp =
          static_cast<double>(statistics_.paths - paths_before) / static_cast<double>(regions_.pixels[0]);
    return image;
  }

  std::vector<RegionError> errors() const {
    const RegionTable table = sum_regions(regions_, light_count_, [&](size_t l, size_t i) {
      const double a = half(0, l, i), b = half(1, l, i);
      // Three estimates of the variance of the mean of the halves: within each, and between them.
      const double within = square(spread(0, l, i)) + square(spread(1, l, i)), between = square(a - b);
      const double variance = (2 * within + between) / 3 / 4;
      return RegionSums{square((a + b) / 2) - variance, variance};
    });
    std::vector<RegionError> errors;
    for (size_t l = 0; l < light_count_; ++l)
      for (size_t r = 0; r < regions_.names.size(); ++r)
        errors.push_back(
            {light_name(l), regions_.names[r], table[l][r].relative_error(), regions_.pixels[r]});
    return errors;
  }

 private:
  std::string light_name(size_t l) const { return streams_[0].empty() ? "" : streams_[0][l].name; }

  std::vector<SampleLight> nothing(bool& met) {
    met = true;
    return render_round(picture_, {1, picture_.even_budget(0)}, statistics_, done_);
  }

  /// The forecast of ever larger pilots, until they take their share of it.
  Forecast forecast() {
    Forecast result;
    for (int spp = kLeastPilotSpp; spp <= kMostPilotSpp; spp *= 4) {
      if (spp > kLeastPilotSpp &&
          (result.mean_spp < kPilotShare * kPilots * spp || kPilots * spp * 2 > goal_.max_spp))
        break;
      result = forecast_of(render_pilots(picture_, kPilots, spp, statistics_, done_), spp);
      pilot_spp_ += kPilots * spp;
    }
    return result;
  }

  Forecast forecast_of(const Pilots& pilots, int pilot_spp) const {
    Forecast result;
    if (picture_.settings.adaptive) {
      const std::vector<uint32_t> budget =
          adaptive_budget(pilots, picture_.seen, picture_.settings.size_px, kBudgetScale);
      for (const uint32_t paths : budget) result.paths.push_back(paths / kBudgetScale);
    } else {
      result.paths.assign(picture_.seen.begin(), picture_.seen.end());
    }
    for (size_t pixel = 0; pixel < result.paths.size(); ++pixel)
      if (regions_.of[pixel].empty()) result.paths[pixel] = 0;  // outside the crop
    const PilotValues values(pilots.images, pilot_spp);
    const auto regions_at = [&] {
      return sum_regions(regions_, light_count_, [&](size_t l, size_t i) {
        const RegionSums one = values(l, i);
        return RegionSums{one.square, one.variance / std::max(result.paths[i / 3], 1e-9)};
      });
    };
    // Each class by its own need; what belongs to no class, by the neediest's.
    if (picture_.settings.adaptive) scale_classes(regions_at(), result.paths);
    const double scale = factor_of(largest_error(regions_at()));
    double sum = 0;
    for (double& paths : result.paths) paths *= scale, sum += paths;
    result.mean_spp = sum / static_cast<double>(regions_.pixels[0]);
    return result;
  }

  /// How many times the paths it takes to come from that error to the goal.
  double factor_of(double error) const {
    const double most = goal_.max_spp;
    const double factor = square(error / goal_.relative_error);
    return std::isfinite(factor) ? std::clamp(factor, 1.0 / kBudgetScale, most) : most;
  }

  void scale_classes(const RegionTable& table, std::vector<double>& paths) const {
    std::vector<double> factors(regions_.names.size(), 0.0);
    for (const std::vector<RegionSums>& light : table)
      for (size_t r = 0; r < factors.size(); ++r)
        factors[r] = std::max(factors[r], factor_of(light[r].relative_error()));
    const double largest = *std::max_element(factors.begin(), factors.end());
    for (size_t pixel = 0; pixel < paths.size(); ++pixel) {
      const std::vector<int>& regions = regions_.of[pixel];
      if (regions.size() == 2)
        paths[pixel] *= std::max(factors[static_cast<size_t>(regions[1])] / largest, kLeastFactor);
    }
  }

  /// Two images a half; a stopped half keeps its images, though it is rendered on for the other to see.
  std::vector<SampleLight> converge(bool& met) {
    const Forecast wanted = forecast();
    const double most = std::max(1.0, 1.0 * goal_.max_spp - pilot_spp_);
    const double most_share = most / wanted.mean_spp;
    std::vector<uint32_t> first(picture_.seen.size(), 0);
    std::array<bool, 2> stopped{};
    const double first_share = std::max(kFirstShare, kFirstLookSpp / wanted.mean_spp);
    for (double share = std::min(first_share, most_share);; share = std::min(share * kGrowth, most_share)) {
      const std::vector<uint32_t> count = next_round(wanted, share, first);
      for (int k = 0; k < kStreams; ++k) grow(k, first, count);
      for (size_t i = 0; i < first.size(); ++i) first[i] += count[i];
      const std::array<double, 2> error = {error_by(0), error_by(1)};
      for (size_t h = 0; h < 2; ++h)
        if (!stopped[h] && error[1 - h] <= goal_.relative_error) {
          stopped[h] = true;
          kept_[h] = {streams_[2 * h], streams_[2 * h + 1]};
        }
      if (round_done_) round_done_(std::max(error[0], error[1]));
      met = stopped[0] && stopped[1];
      if (met || share >= most_share) break;
    }
    for (size_t h = 0; h < 2; ++h)
      if (!stopped[h]) kept_[h] = {streams_[2 * h], streams_[2 * h + 1]};
    std::vector<SampleLight> result = kept_[0][0];
    for (size_t l = 0; l < light_count_; ++l)
      for (size_t i = 0; i < result[l].radiance.values.size(); ++i)
        result[l].radiance.values[i] = static_cast<float>((half(0, l, i) + half(1, l, i)) / 2);
    return result;
  }

  /// Paths that each pixel of one image lacks to have `share` of its part of the forecast.
  std::vector<uint32_t> next_round(const Forecast& wanted, double share,
                                   const std::vector<uint32_t>& first) const {
    std::vector<uint32_t> count(first.size(), 0);
    for (size_t i = 0; i < first.size(); ++i) {
      if (regions_.of[i].empty()) continue;
      const double paths = std::max(1.0, std::round(share * wanted.paths[i] / kStreams));
      count[i] = paths > first[i] ? static_cast<uint32_t>(paths) - first[i] : 0;
    }
    return count;
  }

  void grow(int k, const std::vector<uint32_t>& first, const std::vector<uint32_t>& count) {
    const uint64_t seed =
        mix_bits(mix_bits(picture_.settings.seed) ^ (kStreamSeeds + static_cast<uint64_t>(k)));
    std::vector<SampleLight> round = render_round(picture_, {seed, count, &first}, statistics_, done_);
    std::vector<SampleLight>& mean = streams_[static_cast<size_t>(k)];
    if (mean.empty()) {
      mean = std::move(round);
      return;
    }
    for (size_t l = 0; l < mean.size(); ++l)
      for (size_t i = 0; i < mean[l].radiance.values.size(); ++i) {
        if (count[i / 3] == 0) continue;
        const double total = first[i / 3] + count[i / 3];
        float& value = mean[l].radiance.values[i];
        value = static_cast<float>(
            (double{value} * first[i / 3] + double{round[l].radiance.values[i]} * count[i / 3]) / total);
      }
  }

  /// The error that the mean of both halves has, judged by half h alone.
  double error_by(size_t h) const {
    const std::vector<SampleLight>&a = streams_[2 * h], &b = streams_[2 * h + 1];
    return largest_error(sum_regions(regions_, light_count_, [&](size_t l, size_t i) {
      const double x = a[l].radiance.values[i], y = b[l].radiance.values[i];
      const double variance = square((x - y) / 2);  // of (x + y) / 2
      return RegionSums{square((x + y) / 2) - variance, variance / 2};
    }));
  }

  double half(size_t h, size_t l, size_t i) const {
    return 0.5 * (double{kept_[h][0][l].radiance.values[i]} + kept_[h][1][l].radiance.values[i]);
  }
  double spread(size_t h, size_t l, size_t i) const {
    return 0.5 * (double{kept_[h][0][l].radiance.values[i]} - kept_[h][1][l].radiance.values[i]);
  }

  const Picture& picture_;
  const ErrorGoal& goal_;
  RenderStatistics& statistics_;
  const PixelsDone& done_;
  const RoundDone& round_done_;
  const ErrorRegions regions_;
  const size_t light_count_;
  int pilot_spp_ = 0;
  std::array<std::vector<SampleLight>, kStreams> streams_;       // means so far
  std::array<std::array<std::vector<SampleLight>, 2>, 2> kept_;  // of each half where it stopped
};

}  // namespace

const RegionError* ErrorReport::worst() const {
  const auto less = [](const RegionError& a, const RegionError& b) {
    return a.relative_error < b.relative_error;
  };
  const auto largest = std::max_element(errors.begin(), errors.end(), less);
  return largest == errors.end() ? nullptr : &*largest;
}

const RegionError* ErrorReport::worst_of(const std::string& light) const {
  const RegionError* largest = nullptr;
  for (const RegionError& error : errors)
    if (error.light == light && (!largest || error.relative_error > largest->relative_error))
      largest = &error;
  return largest;
}

std::vector<SampleLight> render_to_error(const LitView& view, const RenderSettings& settings,
                                         const ErrorGoal& goal, ErrorReport& report,
                                         const RenderWatch& watch) {
  const auto start = std::chrono::steady_clock::now();
  const Picture picture(view, settings);
  RenderStatistics unasked;
  RenderStatistics& counted = watch.statistics ? *watch.statistics : unasked;
  ErrorRender render(picture, goal, counted, watch.done, watch.round_done);
  report = {};
  std::vector<SampleLight> image = render.run(report);
  if (report.spp > 0) report.errors = render.errors();
  counted.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return image;
}

}  // namespace ohb::renderer
