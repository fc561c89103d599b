// The small files of shared data's `faults`: each kind of fault once, as its README says is right. The kinds
// have their own tests, which write their files; this one skips where the folder is not there.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "dataset/model/mesh_topology.h"
#include "dataset/model/scan.h"
#include "dataset/surface/picture.h"
#include "tests/support/shared_data.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace surface;
namespace {

namespace fs = std::filesystem;

struct Fault {
  const char* file;  // below `faults`
  std::function<void(const fs::path&)> check;
};

std::ostream& operator<<(std::ostream& out, const Fault& fault) {
  return out << fault.file;
}

/// Reads the scan and looks at it.
std::function<void(const fs::path&)> scan_with(const std::function<void(const Scan&)>& check) {
  return [check](const fs::path& file) { check(read_scan(file)); };
}

float height_of(const Scan& scan) {
  const Bounds bounds = bounds_of_faces(scan);
  return bounds.high.y - bounds.low.y;
}

std::vector<Fault> gltf_faults() {
  return {
      {"01-gltf-skin-axis-in-joints/a.glb",
       scan_with([](const Scan& scan) { EXPECT_NEAR(height_of(scan), 1.7, 1e-5); })},
      {"04-gltf-alphacutoff-ignored/mask_above/a.glb", scan_with([](const Scan& scan) {
         ASSERT_TRUE(scan.materials[0].alpha_cutoff);
         const float value = read_alpha_picture(scan.materials[0]).values[0];
         EXPECT_NEAR(value, 200 / 255.0, 1e-5);
         EXPECT_EQ(scan.materials[0].opacity_of(value), 1);
       })},
      {"04-gltf-alphacutoff-ignored/blend_fac/a.glb",
       scan_with([](const Scan& scan) { EXPECT_EQ(scan.materials[0].opacity_of(1), 0.5f); })},
      {"06-specgloss-white/a.glb", scan_with([](const Scan& scan) {
         EXPECT_FALSE(scan.materials[0].diffuse.empty());
         EXPECT_NE(scan.notes.at(0).find("glossiness"), std::string::npos);
       })},
      {"07-texture-transform-identity-refused/tt_identity/a.glb", scan_with([](const Scan& scan) {
         EXPECT_TRUE(scan.materials[0].diffuse.view.is_plain());
         EXPECT_TRUE(scan.notes.empty());
       })},
      {"07-texture-transform-identity-refused/tt_scale/a.glb", scan_with([](const Scan& scan) {
         for (const Vec2f& uv : scan.uvs) EXPECT_LE(uv.x, 1);  // 2 in the file
         EXPECT_EQ(scan.notes.size(), 1u);
       })},
      {"10-morph-default-weights/morph_w1/a.glb", scan_with([](const Scan& scan) {
         EXPECT_NE(scan.notes.at(0).find("default weights"), std::string::npos);
         EXPECT_NEAR(height_of(scan), 1.7, 1e-5);
       })},
      {"12-clear-shell-opaque/cornea.glb",
       scan_with([](const Scan& scan) { EXPECT_FLOAT_EQ(scan.materials.at(1).opacity_of(1), 0.05f); })},
      {"15-meshopt-called-truncated/meshopt_fallback.glb",
       [](const fs::path& file) {
         expect_message(input_error_of([&] { read_scan(file); }),
                        {"EXT_meshopt_compression", "without compression"});
       }},
      {"19-vertex-colours-silent/vcol/a.glb", scan_with([](const Scan& scan) {
         EXPECT_TRUE(scan.materials[0].has_vertex_colours);
         EXPECT_EQ(scan.notes.size(), 1u);
       })},
      {"20-sampler-wrap-ignored/mirror_wrap/a.glb",
       scan_with([](const Scan& scan) { EXPECT_FALSE(scan.materials[0].diffuse.view.is_plain()); })},
  };
}

class Faults : public testing::TestWithParam<Fault> {};

TEST_P(Faults, IsRightOrRefusedInWords) {
  OHB_SHARED_DATA_OR_SKIP(folder, "faults");
  GetParam().check(folder / GetParam().file);
}

INSTANTIATE_TEST_SUITE_P(Gltf, Faults, testing::ValuesIn(gltf_faults()));

}  // namespace
}  // namespace ohb
