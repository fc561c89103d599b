// Rays onto a source, eight at a time beside one by one, and through layers that lie on each other.
#include "bake/source_rays.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/bake/test_scans.h"

namespace ohb {
using namespace bake;
using namespace surface;
namespace {

// As many layers as are passed at most: one that was met twice (see renderer/intersect_test) would count as
// two, and the face behind them would be missed.
TEST(SourceRays, EachLayerIsPassedOnce) {
  constexpr float kApart_cm = 1e-5f;  // a third of a ray's start
  Model high;
  for (int layer = 0; layer < 5; ++layer) {
    const Model sheet = height_field(
        8, 10, [&](float x, float y) { return 0.3f * x - 0.2f * y - kApart_cm * static_cast<float>(layer); });
    high = layer == 0 ? turned_over(sheet) : joined(high, layer < 4 ? turned_over(sheet) : sheet);
  }
  const SourceSurface surface(scan_of_model(high, "high.obj"), 1, {0, 0, 0}, {});
  std::mt19937 random(6);
  std::uniform_real_distribution<float> any(0, 1);
  int missed = 0;
  constexpr int kPackets = 20'000;
  for (int round = 0; round < kPackets; ++round) {
    RayPacket packet;
    packet.count = RayPacket::kSize;
    packet.inward_cm = 1;
    for (int i = 0; i < packet.count; ++i) {
      const float x = 0.5f + 9 * any(random), y = 0.5f + 9 * any(random);
      packet.origin[i] = {x, y, 0.3f * x - 0.2f * y};
      packet.direction[i] = normalised({any(random) - 0.8f, any(random) - 0.3f, 1});
    }
    SourcePoint points[RayPacket::kSize];
    find_source(surface, packet, points);
    for (int i = 0; i < packet.count; ++i) {
      const SourcePoint one = find_source_of_one(surface, packet.origin[i], packet.direction[i], 0, 1);
      missed += points[i].result != RayResult::kHit || one.result != RayResult::kHit;
    }
  }
  EXPECT_EQ(missed, 0);
}

TEST(SourceRays, PacketsFindWhatSingleRaysFind) {
  const Model high = sphere_model(30, 90, TextureSet());
  const SourceSurface surface(scan_of_model(high, "high.obj"), 1, {0, 0, 0}, {});
  std::mt19937 random(5);
  std::uniform_real_distribution<float> any(-1, 1);
  int found = 0;
  for (int round = 0; round < 500; ++round) {
    RayPacket packet;
    packet.count = 1 + round % RayPacket::kSize;
    packet.inward_cm = 2;
    for (int i = 0; i < packet.count; ++i) {
      packet.direction[i] = normalised({any(random), any(random), any(random)});
      packet.origin[i] = Vec3f{0, 30, 0} + (30 + 4 * any(random)) * packet.direction[i];
      if (i % 3 == 0) packet.direction[i] = -packet.direction[i];  // only back faces
      packet.outward_cm[i] = 3;
    }
    SourcePoint points[RayPacket::kSize];
    find_source(surface, packet, points);
    for (int i = 0; i < packet.count; ++i) {
      const SourcePoint one = find_source_of_one(surface, packet.origin[i], packet.direction[i],
                                                 packet.outward_cm[i], packet.inward_cm);
      EXPECT_EQ(points[i].result, one.result);
      if (one.result != RayResult::kHit) continue;
      EXPECT_NEAR(points[i].distance_cm, one.distance_cm, 1e-4f);
      ++found;
    }
  }
  EXPECT_GT(found, 500);
}

}  // namespace
}  // namespace ohb
