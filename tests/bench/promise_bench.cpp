// Do --error and --quality auto keep what they promise? One line a scene.
// usage: promise_bench [--error X] [--tolerance X] [--size PX] NAME MODEL VIEW/COUNT LIGHT...
// LIGHT is an environment or x,y,z,I. MODEL is below the folder OHB_MODELS, if that is set.
// --error: root mean square over six seeds of the real error of each light and of what was said; the truth is
//   the mean of two images of plain --spp with as many paths each, whose own error is taken off.
// --tolerance: the change by what auto leaves out, from independent images, and the processor time of both:
// an
//   image, and to equal noise.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "dataset/commands/render_samples.h"
#include "dataset/model/stopwatch.h"
#include "renderer/paired_pilots.h"

namespace ohb {
using namespace commands;
using namespace renderer;
using namespace surface;
namespace {

struct Bench {
  double error = 0, tolerance = 0;
  int size_px = 64;
  std::string name;
  Model model;
  std::vector<Environment> environments;
  std::vector<PointLight> points;
  double turn_rad = 0;

  Camera camera() const { return fit_camera(model.positions_cm); }
  RenderSettings settings(uint64_t seed) const {
    RenderSettings s;
    s.size_px = size_px;
    s.seed = seed;
    s.adaptive = true;
    return s;
  }
};

double squares_of(const Image& a, const Image* b) {
  double sum = 0;
  for (size_t i = 0; i < a.values.size(); ++i)
    sum += std::pow(double{a.values[i]} - (b ? b->values[i] : 0.0f), 2);
  return sum;
}

double said_of_subject(const ErrorReport& report, const std::string& light) {
  for (const RegionError& e : report.errors)
    if (e.light == light && e.region == "subject") return e.relative_error;
  return 0;
}

void check_error(const Bench& b) {
  constexpr int kSeeds = 6;
  const auto scene = build_scene(b.model);
  const auto lights = prepare_lights(b.environments, b.points);
  std::vector<std::vector<SampleLight>> images, truths;
  std::vector<ErrorReport> reports(kSeeds);
  const Stopwatch watch;
  for (uint64_t k = 0; k < kSeeds; ++k)
    images.push_back(render_to_error({*scene, *lights, b.camera(), b.turn_rad}, b.settings(1 + k),
                                     {b.error, 1 << 20}, reports[k]));
  const double cpu_s = watch.cpu_s() / kSeeds;
  for (uint64_t k = 0; k < 2; ++k) {
    RenderSettings settings = b.settings(100 + k);
    settings.spp = static_cast<int>(reports[0].spp);
    truths.push_back(render_lights({*scene, *lights, b.camera(), b.turn_rad}, settings));
  }
  for (size_t l = 0; l < images[0].size(); ++l) {
    Image truth = truths[0][l].radiance;
    for (size_t i = 0; i < truth.values.size(); ++i)
      truth.values[i] = 0.5f * (truth.values[i] + truths[1][l].radiance.values[i]);
    const double of_truth = squares_of(truths[0][l].radiance, &truths[1][l].radiance) / 4;
    double real = 0, said = 0, worst = 0, paths = 0;
    for (size_t k = 0; k < kSeeds; ++k) {
      real += (squares_of(images[k][l].radiance, &truth) - of_truth) / squares_of(truth, nullptr) / kSeeds;
      said += std::pow(said_of_subject(reports[k], images[k][l].name), 2) / kSeeds;
      worst = std::max(worst, reports[k].worst_of(images[k][l].name)->relative_error);
      paths += reports[k].spp / kSeeds;
    }
    std::printf(
        "%-26s %-16s goal %.3g  subject: real %.4f (of goal %.2f) said %.4f (said/real %.2f)  worst class "
        "said %.4f  %.0f paths a pixel, %.1f s processor\n",
        b.name.c_str(), images[0][l].name.c_str(), b.error, std::sqrt(std::max(0.0, real)),
        std::sqrt(std::max(0.0, real)) / b.error, std::sqrt(said), std::sqrt(said / real), worst, paths,
        cpu_s);
    std::fflush(stdout);
  }
}

/// Variance of one image of light `l`, summed over the pixels.
double noise_of(const PilotStack& stack, size_t l) {
  const auto count = static_cast<double>(stack.size());
  double variance = 0;
  for (size_t i = 0; i < stack[0][l].size(); ++i) {
    double sum = 0, squares = 0;
    for (const auto& image : stack) sum += image[l][i], squares += double{image[l][i]} * image[l][i];
    variance += (squares - sum * sum / count) / (count - 1);
  }
  return variance;
}

void check_quality(const Bench& b) {
  const std::vector<QualityView> views{{b.camera(), b.turn_rad}};
  constexpr int kJobViews = 100, kImages = 48;  // as a view of a series
  const Stopwatch choosing;
  PreparedScene prepared[2] = {prepare_scene(b.model, b.environments, b.points, views, b.settings(1), {}),
                               prepare_scene(b.model, b.environments, b.points, views, b.settings(1),
                                             {Quality::kAuto, b.tolerance, kJobViews})};
  const double choosing_s = choosing.cpu_s();
  PilotStack stacks[2];
  double cpu_s[2] = {};
  for (uint64_t k = 0; k < kImages; ++k)
    for (int which : {0, 1}) {
      const PreparedScene& p = prepared[which];
      const Stopwatch watch;
      stacks[which].emplace_back();
      for (const SampleLight& light :
           render_lights({*p.lit, *p.lights, b.camera(), b.turn_rad},
                         p.settings_for(b.settings(1000 + 2 * k + static_cast<uint64_t>(which)))))
        stacks[which].back().push_back(light.radiance.values);
      cpu_s[which] += watch.cpu_s();
    }
  const auto root = [](double x) { return std::sqrt(std::max(0.0, x)); };
  for (size_t l = 0; l < stacks[0][0].size(); ++l) {
    const SquaredDifference d = squared_difference(stacks[0], l, stacks[1], l, 0.02);
    const double noise = noise_of(stacks[0], l) / noise_of(stacks[1], l);
    std::printf(
        "%-26s light %zu tolerance %.3g  said at most %.4f  real %.4f (98 %%: %.4f to %.4f)  processor time "
        "reference/auto %.2f, to equal noise %.2f  (%.1f s an image; choosing took %.1f s)\n",
        b.name.c_str(), l, b.tolerance, prepared[1].error_high, root(d.value), root(d.low), root(d.high),
        cpu_s[0] / cpu_s[1], noise * cpu_s[0] / cpu_s[1], cpu_s[0] / kImages, choosing_s);
  }
  for (const Omission& o : prepared[1].tried)
    std::printf("    %s %s: %.4f (%.4f to %.4f)\n", o.is_left_out ? "left out" : "kept", o.what.c_str(),
                o.error, o.low, o.high);
  std::fflush(stdout);
}

int run(int argc, char** argv) {
  Bench b;
  std::vector<std::string> words;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--error" && i + 1 < argc)
      b.error = std::atof(argv[++i]);
    else if (word == "--tolerance" && i + 1 < argc)
      b.tolerance = std::atof(argv[++i]);
    else if (word == "--size" && i + 1 < argc)
      b.size_px = std::atoi(argv[++i]);
    else
      words.push_back(word);
  }
  if (words.size() < 4) {
    std::fprintf(
        stderr,
        "usage: promise_bench [--error X] [--tolerance X] [--size PX] NAME MODEL VIEW/COUNT LIGHT...\n");
    return 2;
  }
  const char* folder = std::getenv("OHB_MODELS");
  b.name = words[0];
  b.model = read_model(folder ? std::filesystem::path(folder) / words[1] : std::filesystem::path(words[1]));
  b.turn_rad =
      turn_of_view(std::atoi(words[2].c_str()), std::atoi(words[2].c_str() + words[2].find('/') + 1));
  for (size_t i = 3; i < words.size(); ++i)
    if (words[i].find(".exr") != std::string::npos)
      b.environments.push_back(read_environment(words[i]));
    else
      b.points.push_back(parse_point_light(words[i], b.points.size()));
  if (b.error > 0) check_error(b);
  if (b.tolerance > 0) check_quality(b);
  return 0;
}

}  // namespace
}  // namespace ohb

int main(int argc, char** argv) {
  return ohb::run(argc, argv);
}
