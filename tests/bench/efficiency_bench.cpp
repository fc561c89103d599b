// What a renderer's minute buys: 1 / (mean squared error x processor time), of one view without loading.
// usage: efficiency_bench MODEL E.exr[,E.exr...] [SPP [SIZE_PX [adaptive] [diffuse] [unguessed]]]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "dataset/model/stopwatch.h"
#include "renderer/render.h"

int main(int argc, char** argv) {
  using namespace ohb;
  using namespace ohb::renderer;
  if (argc < 3) {
    std::fprintf(
        stderr,
        "usage: efficiency_bench MODEL E.exr[,E.exr...] [SPP [SIZE_PX [adaptive] [diffuse] [unguessed]]]\n");
    return 2;
  }
  constexpr int kSeeds = 8;
  const Model model = read_model(argv[1]);
  const auto scene = build_scene(model);
  std::vector<Environment> environments;
  std::istringstream files(argv[2]);
  for (std::string file; std::getline(files, file, ',');) environments.push_back(read_environment(file));
  const auto lights = prepare_lights(environments, {});
  RenderSettings settings;
  settings.spp = argc > 3 ? std::atoi(argv[3]) : 16;
  settings.size_px = argc > 4 ? std::atoi(argv[4]) : 256;
  const auto says = [&](const char* word) {
    return std::find(argv + std::min(argc, 5), argv + argc, std::string(word)) != argv + argc;
  };
  settings.adaptive = says("adaptive");
  settings.subsurface = !says("diffuse");
  settings.guess_shadows = !says("unguessed");
  std::vector<std::vector<float>> images;  // of all lights
  const Stopwatch watch;
  RenderStatistics statistics;
  for (int k = 0; k < kSeeds; ++k) {
    settings.seed = static_cast<uint64_t>(k) + 1;
    std::vector<float>& values = images.emplace_back();
    for (const SampleLight& light :
         render_lights({*scene, *lights, fit_camera(model.positions_cm), 0}, settings, &statistics))
      values.insert(values.end(), light.radiance.values.begin(), light.radiance.values.end());
  }
  const double seconds = watch.cpu_s() / kSeeds;
  double error = 0, square = 0;
  size_t below_0 = 0;
  for (size_t i = 0; i < images[0].size(); ++i) {
    double sum = 0, squares = 0;
    for (const std::vector<float>& values : images)
      below_0 += values[i] < 0, sum += values[i], squares += double{values[i]} * values[i];
    error += (squares - sum * sum / kSeeds) / (kSeeds - 1);
    square += sum * sum / kSeeds / kSeeds;
  }
  std::printf(
      "relative MSE %.4e  processor %.3f s an image  efficiency %.4g  rays a path %.2f  below 0: %zu of "
      "%zu\n",
      error / square, seconds, square / (error * seconds),
      static_cast<double>(statistics.closest_hit_rays + statistics.shadow_rays) /
          static_cast<double>(statistics.paths),
      below_0, kSeeds * images[0].size());
  return 0;
}
