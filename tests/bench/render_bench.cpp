// Rays per second of the renderer beside bare Embree's on the very same rays, one thread each.
// usage: render_bench [MODEL E.exr] [Google Benchmark's options]; without a model: a lumpy ball of 100,000
// triangles under a constant environment. The ratio of `rays` is the share of Embree's rate that remains; the
// fair one is that to packets, since the renderer traces rays eight at once where nothing is cut out.
#include <benchmark/benchmark.h>
#include <pmmintrin.h>
#include <tbb/global_control.h>
#include <xmmintrin.h>

#include <cstdio>
#include <string>

#include "renderer/intersect.h"
#include "tests/support/test_models.h"

namespace ohb {
using namespace renderer;
using namespace surface;
namespace {

struct Workload {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const LightSet> lights;
  Camera camera;
  RenderSettings settings;
  std::vector<RecordedRay> rays;
};

Workload g_workload;

Model lumpy_ball() {
  Model model = sphere_model(80, 316, constant_set({}, 512));
  for (Vec3f& p : model.positions_cm)
    p = p + 2 * std::sin(0.4f * p.x) * std::sin(0.5f * p.y) * Vec3f{0, 0, 1};
  return model;
}

Workload make_workload(const char* model_folder, const char* environment_file) {
  Workload w;
  Environment environment;
  environment.name = "constant";
  environment.radiance = constant_radiance({1, 1, 1});
  const Model model = model_folder ? read_model(model_folder) : lumpy_ball();
  if (environment_file) environment = read_environment(environment_file);
  w.scene = build_scene(model);
  w.lights = prepare_lights({environment}, {});
  w.camera = fit_camera(model.positions_cm);
  w.settings.size_px = 256;
  w.settings.spp = 32;  // so that what is done once an image does not hide the rays
  RenderStatistics statistics;
  statistics.record = &w.rays;
  render_lights({*w.scene, *w.lights, w.camera, 0}, w.settings, &statistics);
  std::printf("%zu triangles, %zu rays recorded\n", model.triangles.size(), w.rays.size());
  return w;
}

void trace_one(const RecordedRay& ray) {
  RTCScene bvh = ray.is_cutout ? g_workload.scene->cutout : g_workload.scene->opaque;
  RTCRayHit r = embree_ray({ray.origin, ray.direction}, ray.t_near, ray.t_far);
  if (ray.is_shadow)
    occluded_one(bvh, r.ray);
  else
    intersect_one(bvh, r);
  benchmark::DoNotOptimize(r.ray.tfar);
}

/// Rays of one kind.
void trace_packet(const RecordedRay* rays, int count) {
  alignas(32) int valid[8];
  RTCRayHit8 r;
  for (int i = 0; i < 8; ++i) {
    const RecordedRay& ray = rays[i < count ? i : 0];
    valid[i] = i < count ? -1 : 0;
    set_lane(r.ray, i, {ray.origin, ray.direction}, ray.t_far);
    r.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID, r.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  if (rays->is_shadow)
    occluded_eight(g_workload.scene->opaque, valid, r.ray);
  else
    intersect_eight(g_workload.scene->opaque, valid, r, false);
  benchmark::DoNotOptimize(r.ray.tfar[0]);
}

/// `at_once`: of rays against opaque triangles that follow each other and are of one kind, as the renderer
/// traces them where nothing is cut out.
void bare_embree(benchmark::State& state, size_t at_once) {
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
  _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
  const std::vector<RecordedRay>& rays = g_workload.rays;
  for (auto _ : state)
    for (size_t i = 0; i < rays.size();) {
      size_t end = i;
      while (end < rays.size() && end < i + at_once && rays[end].is_shadow == rays[i].is_shadow &&
             !rays[end].is_cutout)
        ++end;
      if (end > i + 1)
        trace_packet(&rays[i], static_cast<int>(end - i));
      else
        trace_one(rays[i]), end = i + 1;
      i = end;
    }
  const double count = static_cast<double>(rays.size()) * static_cast<double>(state.iterations());
  state.counters["rays"] = benchmark::Counter(count, benchmark::Counter::kIsRate);
}

void our_renderer(benchmark::State& state) {
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  for (auto _ : state)
    benchmark::DoNotOptimize(
        render_lights({*g_workload.scene, *g_workload.lights, g_workload.camera, 0}, g_workload.settings));
  const double rays = static_cast<double>(g_workload.rays.size()) * static_cast<double>(state.iterations());
  state.counters["rays"] = benchmark::Counter(rays, benchmark::Counter::kIsRate);
}

}  // namespace
}  // namespace ohb

int main(int argc, char** argv) {
  const bool has_model = argc >= 3 && argv[1][0] != '-';
  ohb::g_workload = ohb::make_workload(has_model ? argv[1] : nullptr, has_model ? argv[2] : nullptr);
  benchmark::RegisterBenchmark("bare_embree", ohb::bare_embree, 1)->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("bare_embree_packets", ohb::bare_embree, 8)->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("renderer", ohb::our_renderer)->Unit(benchmark::kMillisecond);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
