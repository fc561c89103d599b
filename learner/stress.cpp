#include "learner/stress.h"

#include <cmath>
#include <ctime>
#include <map>

#include "dataset/model/error.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/progress.h"
#include "learner/estimator.h"
#include "learner/hash.h"
#include "learner/relit_scores.h"
#include "learner/stress_cases.h"
#include "learner/unseen.h"

namespace ohb::learner {
namespace {

using torch::Tensor;
namespace F = torch::nn::functional;

constexpr Vec3f kSun_cm{600, 800, 700};  // of the viewer's right, above and before the person

/// Constant radiance from everywhere, and a small lamp far away.
std::shared_ptr<const renderer::LightSet> sky_and_sun() {
  Environment sky;
  sky.name = "sky";
  sky.radiance = Image(64, 32, 3);
  std::fill(sky.radiance.values.begin(), sky.radiance.values.end(), 1.0f);
  return renderer::prepare_lights({sky}, {{"sun", kSun_cm, 100}});
}

/// Means over the foreground made equal.
void balance(StressSubject& s) {
  const Tensor inside = s.example.mask > 0.5;
  for (Tensor* light : {&s.sky, &s.sun}) {
    *light = light->nan_to_num(0);
    *light = *light / light->masked_select(inside).mean().clamp_min(1e-9);
  }
}

Tensor resized_to(const Tensor& x, int64_t side) {
  if (x.size(3) == side) return x;
  const std::vector<int64_t> size = {side, side};
  // Down by areas, as photographs are; up by lines.
  if (side < x.size(3)) return F::interpolate(x, F::InterpolateFuncOptions().size(size).mode(torch::kArea));
  return F::interpolate(x,
                        F::InterpolateFuncOptions().size(size).mode(torch::kBilinear).align_corners(false));
}

/// Difference of two albedos over their mean, over the foreground.
double change_of(const Tensor& a, const Tensor& b, const Tensor& mask) {
  const Tensor inside = (mask > 0.5).expand(a.sizes());
  return ((a - b).abs().masked_select(inside).mean() / b.masked_select(inside).mean().clamp_min(1e-6))
      .item<double>();
}

Tensor logarithm_of_luma(const Tensor& linear) {
  const Tensor weights = torch::tensor({0.2126f, 0.7152f, 0.0722f}).view({1, 3, 1, 1});
  return ((linear * weights).sum(1, true) + 1e-3).log();
}

/// Correlation of ln(estimate / truth) with ln(picture / truth).
double baked_in(const Tensor& albedo, const Tensor& truth, const Tensor& srgb, const Tensor& mask) {
  const Tensor inside = mask > 0.5;
  const auto centred = [&](const Tensor& x) {
    const Tensor values = x.masked_select(inside).to(torch::kDouble);
    return values - values.mean();
  };
  const Tensor error = centred(logarithm_of_luma(albedo) - logarithm_of_luma(truth));
  const Tensor shading = centred(logarithm_of_luma(linear_of(srgb)) - logarithm_of_luma(truth));
  return ((error * shading).sum() / (error.square().sum() * shading.square().sum()).sqrt().clamp_min(1e-12))
      .item<double>();
}

/// The colours that an input shows, sRGB, without the mask in them.
Tensor colours_of(const Tensor& input) {
  const Tensor mask = (input.slice(1, 3, 4) + 1) / 2;
  return ((input.slice(1, 0, 3) + 1) / 2 / mask.clamp_min(1e-3)).clamp(0, 1);
}

/// Sums of one level over pictures.
struct LevelSum {
  MeanOf<Scores> psnr;
  MeanOf<Measures> measures;
  MeanOf<std::array<double, 4>> others;
};

class Stress {
 public:
  Stress(const Estimator& estimator, std::vector<StressKind> kinds)
      : estimator_(estimator), kinds_(std::move(kinds)) {}

  void add(const StressSubject& subject) {
    const StressKind& first = kinds_.front();
    const Tensor harmless = estimated(first.picture(subject, first.harmless)).maps.diffuse;
    for (const StressKind& kind : kinds_)
      for (const double level : kind.levels) {
        throw_if_interrupted();
        const StressPicture picture = kind.picture(subject, level);
        const Timed timed = estimated(picture);
        LevelSum& sum = sums_[{kind.name, level}];
        sum.psnr.add(scores_of(timed.maps, picture.truth, picture.mask));
        sum.measures.add(measures_of(timed.maps, picture.truth, picture.mask));
        const Tensor srgb = colours_of(picture.input);
        sum.others.add(
            {psnr(srgb, srgb_of(picture.truth.diffuse), picture.mask).masked,
             picture.same_pixels ? change_of(timed.maps.diffuse, harmless, picture.mask) : std::nan(""),
             baked_in(timed.maps.diffuse, picture.truth.diffuse, srgb, picture.mask), timed.seconds});
      }
  }

  StressReport report() const {
    StressReport report;
    for (const StressKind& kind : kinds_) {
      StressSeries series{kind.name, kind.parameter, kind.harmless, {}};
      for (const double level : kind.levels) {
        const LevelSum& sum = sums_.at({kind.name, level});
        const auto [input_dB, change, baked, seconds] = sum.others.mean();
        series.levels.push_back({level, sum.psnr.count(), sum.psnr.mean(), sum.measures.mean(), input_dB,
                                 change, baked, seconds});
      }
      report.series.push_back(series);
    }
    return report;
  }

 private:
  struct Timed {
    MaterialMaps maps;
    double seconds;
  };

  /// At the picture's size, however large the networks saw it.
  Timed estimated(const StressPicture& picture) const {
    const std::clock_t start = std::clock();
    MaterialMaps maps = estimator_.estimate(resized_to(picture.input, picture.network_px).contiguous());
    const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    for (const LearnedMap& map : kMaps) maps.*map.tensor = resized_to(maps.*map.tensor, picture.mask.size(3));
    return {maps, seconds};
  }

  const Estimator& estimator_;
  std::vector<StressKind> kinds_;
  std::map<std::pair<std::string, double>, LevelSum> sums_;
};

}  // namespace

std::vector<double> StressSeries::broken() const {
  double harmless_dB = 0;
  std::vector<double> found;
  for (const StressLevel& l : levels)
    if (l.level == harmless) harmless_dB = l.psnr[1].masked;
  for (const StressLevel& l : levels)
    if (l.psnr[1].masked < harmless_dB - kBroken_dB) found.push_back(l.level);
  return found;
}

StressReport run_stress(const StressOptions& options) {
  const Estimator estimator(options.weights, PriorsNeeded::kAll, options.device);
  const Dataset dataset = read_dataset(options.data);
  const std::vector<std::string> people = people_to_judge(options.people, dataset, estimator.headers());
  const int size_px = options.size_px > 0 ? options.size_px : estimator.header().at("size_px").get<int>();
  if (size_px % kResolutionStep != 0)
    throw InputError("", "--size " + std::to_string(size_px), "is no multiple of 16", "give another");
  const auto views = relit_views(dataset, people, options.views_a_person);
  const auto lights = sky_and_sun();
  Stress stress(estimator, stress_kinds(size_px));
  Progress progress("stress", views.size(), options.quiet);
  uint64_t number = 0;
  for (const auto& [view, light] : views) {
    const Sample sample = read_sample(view);
    StressSubject subject;
    subject.example = example_of(sample, view, light, size_px);
    const Example& e = subject.example;
    const auto radiance =
        relit_radiance(e.truth, e.mask, camera_of(sample, view), e.half_frame_cm, *lights, options.spp);
    subject.sky = radiance.at(0);
    subject.sun = radiance.at(1);
    subject.key = key_of({options.seed, number++});
    balance(subject);
    stress.add(subject);
    progress.add();
  }
  StressReport report = stress.report();
  report.people = people.size();
  report.size_px = size_px;
  return report;
}

}  // namespace ohb::learner
