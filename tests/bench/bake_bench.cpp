// The ray part of a bake beside bare Embree: the same packets, one thread each. A lumpy ball of 500,000
// triangles is sought from a ball of 20,000 in the order of a 1024 x 1024 map. usage: bake_bench [Google
// Benchmark's options]. The ratio of the `texels` counters is the share of Embree's rate that remains once
// facing, limits and the choice between the two ways are done.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>

#include "bake/source_bake.h"
#include "tests/bake/test_scans.h"

namespace ohb {
using namespace bake;
using namespace surface;
namespace {

constexpr float kReach_cm = 2;

struct Workload {
  std::unique_ptr<SourceSurface> surface;
  std::vector<RayPacket> packets;
  double texels = 0;
};

Workload g_workload;

/// With one position at each pole, whose normal is then the ball's.
Model ball(int columns) {
  Model model = sphere_model(80, columns, TextureSet());
  const uint32_t row = static_cast<uint32_t>(columns) + 1, last = static_cast<uint32_t>(columns) / 2 * row;
  for (ModelTriangle& triangle : model.triangles)
    for (uint32_t& p : triangle.position) p = p < row ? 0 : p >= last ? last : p;
  return model;
}

Workload make_workload() {
  Workload w;
  Model high = ball(708);
  for (Vec3f& p : high.positions_cm)
    p = p + 0.3f * std::sin(0.9f * p.x) * std::sin(1.1f * p.y) * std::cos(0.8f * p.z) * Vec3f{1, 1, 1};
  w.surface = std::make_unique<SourceSurface>(scan_of_model(high, "high.obj"), 1, Vec3f{0, 0, 0},
                                              std::vector<GreenChannel>{});
  const Model low = ball(142);
  const MeshFrames frames = frames_of(low);
  std::vector<UvTriangle> uvs;
  for (const ModelTriangle& t : low.triangles)
    uvs.push_back({{low.uvs[t.uv[0]], low.uvs[t.uv[1]], low.uvs[t.uv[2]]}});
  constexpr int kSize = 1024;
  const TexelCoverage coverage = cover_texels(uvs, kSize, kSize);
  for (int row = 0; row < kSize; ++row) {
    RayPacket packet;
    packet.inward_cm = kReach_cm;
    for (int x = 0; x < kSize; ++x) {
      const uint32_t owner = coverage.owner_of(x, row);
      if (owner == TexelCoverage::kNone) continue;
      const NearestPoint near =
          nearest_point_of_texel(to_texel_space(uvs[owner], kSize, kSize), kSize, kSize, x, row);
      Vec3f position, normal;
      for (int c = 0; c < 3; ++c) {
        position += static_cast<float>(near.weights[c]) * low.positions_cm[low.triangles[owner].position[c]];
        normal += static_cast<float>(near.weights[c]) * frames.normals[low.triangles[owner].position[c]];
      }
      packet.origin[packet.count] = position;
      packet.direction[packet.count] = normalised(normal);
      packet.outward_cm[packet.count] = kReach_cm;
      if (++packet.count < RayPacket::kSize) continue;
      w.packets.push_back(packet);
      w.texels += RayPacket::kSize;
      packet.count = 0;
    }
  }
  std::printf("%zu triangles, %.0f texels\n", w.surface->triangle_count(), w.texels);
  return w;
}

void count_texels(benchmark::State& state) {
  state.counters["texels"] = benchmark::Counter(g_workload.texels * static_cast<double>(state.iterations()),
                                                benchmark::Counter::kIsRate);
}

void bare_embree(benchmark::State& state) {
  alignas(32) const int valid[8] = {-1, -1, -1, -1, -1, -1, -1, -1};
  for (auto _ : state) {
    float sum = 0;
    for (const RayPacket& packet : g_workload.packets)
      for (float sign : {1.0f, -1.0f}) {
        alignas(32) RTCRayHit8 r;
        for (int i = 0; i < 8; ++i) {
          const Vec3f o = packet.origin[i], d = sign * packet.direction[i];
          r.ray.org_x[i] = o.x, r.ray.org_y[i] = o.y, r.ray.org_z[i] = o.z;
          r.ray.dir_x[i] = d.x, r.ray.dir_y[i] = d.y, r.ray.dir_z[i] = d.z;
          r.ray.tnear[i] = 0, r.ray.tfar[i] = kReach_cm, r.ray.time[i] = 0;
          r.ray.mask[i] = 0xffffffffu, r.ray.id[i] = 0, r.ray.flags[i] = 0;
          r.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID, r.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        }
        intersect_eight(g_workload.surface->bvh(), valid, r, true);
        sum += r.ray.tfar[0];
      }
    benchmark::DoNotOptimize(sum);
  }
  count_texels(state);
}

void find_source_of_packets(benchmark::State& state) {
  for (auto _ : state) {
    SourcePoint points[RayPacket::kSize];
    for (const RayPacket& packet : g_workload.packets) {
      find_source(*g_workload.surface, packet, points);
      benchmark::DoNotOptimize(points);
    }
  }
  count_texels(state);
}

}  // namespace
}  // namespace ohb

int main(int argc, char** argv) {
  ohb::g_workload = ohb::make_workload();
  benchmark::RegisterBenchmark("bare_embree", ohb::bare_embree)->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("find_source", ohb::find_source_of_packets)->Unit(benchmark::kMillisecond);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
