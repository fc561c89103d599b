#include "dataset/surface/triangle_tree.h"

#include <new>
#include <stdexcept>
#include <string>
#include <utility>

namespace ohb::surface {
namespace {

void throw_embree_error(void*, RTCError code, const char* message) {
  throw std::runtime_error("Embree error " + std::to_string(code) + ": " + message);
}

}  // namespace

TriangleTree::TriangleTree(const std::vector<Vec3f>& positions, const uint32_t* corners,
                           size_t triangle_count, TreeOptions options) {
  if (triangle_count == 0) return;
  device_ = rtcNewDevice(nullptr);
  if (!device_) throw std::bad_alloc();  // the only thing that it can lack here
  rtcSetDeviceErrorFunction(device_, throw_embree_error, nullptr);
  RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions.data(), 0,
                             sizeof(Vec3f), positions.size() - 1);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, corners, 0,
                             3 * sizeof(uint32_t), triangle_count);
  rtcCommitGeometry(geometry);
  scene_ = rtcNewScene(device_);
  if (options.is_robust) rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
  // Splitting triangles (HIGH) takes three times as long to build, and people's even meshes are no faster by
  // it.
  rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_MEDIUM);
  if (options.has_filters) allow_filters(scene_, geometry);
  rtcAttachGeometry(scene_, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene_);
}

TriangleTree::~TriangleTree() {
  if (scene_) rtcReleaseScene(scene_);
  if (device_) rtcReleaseDevice(device_);
}

TriangleTree::TriangleTree(TriangleTree&& other) noexcept
    : device_(std::exchange(other.device_, nullptr)), scene_(std::exchange(other.scene_, nullptr)) {}

TriangleTree& TriangleTree::operator=(TriangleTree&& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(scene_, other.scene_);
  return *this;
}

}  // namespace ohb::surface
