#include "dataset/model/mesh_topology.h"

#include "dataset/model/scan_unit.h"
#include "tests/support/scan_files.h"
#include "tests/support/test_files.h"

namespace ohb {
namespace {

Scan scan_of(const std::string& text) {
  const TemporaryFolder folder;
  return read_scan(write_bytes(folder / "scan.obj", text));
}

/// A box 1 x `height` x 1 of six quads, soles at y = 0.
std::string box_obj(double height, const std::string& order = "xyz") {
  std::string text;
  for (int i = 0; i < 8; ++i) {
    const double x = i & 1 ? 1 : 0, y = i & 2 ? height : 0, z = i & 4 ? 1 : 0;
    text += "v";
    for (char axis : order) text += " " + std::to_string(axis == 'x' ? x : axis == 'y' ? y : z);
    text += "\n";
  }
  return text + "f 1 3 4 2\nf 5 6 8 7\nf 1 5 7 3\nf 2 4 8 6\nf 1 2 6 5\nf 3 7 8 4\n";
}

TEST(MeshTopology, ClosedBox) {
  const MeshTopology topology = mesh_topology(scan_of(box_obj(2)));
  EXPECT_EQ(topology.point_count, 8u);
  ASSERT_EQ(topology.edges.size(), 12u);
  for (const MeshEdge& edge : topology.edges) {
    ASSERT_EQ(edge.use_count, 2u);
    EXPECT_NE(topology.uses[edge.first_use].forward, topology.uses[edge.first_use + 1].forward);
  }
  EXPECT_EQ(topology.component_count, 1u);
}

TEST(MeshTopology, WeldsAcrossSeamsAndNotBeyond) {
  // Two triangles that share an edge up to 1e-6, a third one apart by 1e-2, and an unused vertex far away.
  const MeshTopology topology =
      mesh_topology(scan_of("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1.000001 0 0\nv 0 1.000001 0\nv 1 1 0\n"
                            "v 1.01 0 0\nv 1 1.01 0\nv 2 1 0\nv 1e6 0 0\nf 1 2 3\nf 4 6 5\nf 7 9 8\n"));
  EXPECT_EQ(topology.point_of_position[1], topology.point_of_position[3]);
  EXPECT_EQ(topology.point_of_position[2], topology.point_of_position[4]);
  EXPECT_NE(topology.point_of_position[1], topology.point_of_position[6]);
  EXPECT_EQ(topology.point_of_position[9], MeshTopology::kNoPoint);
  EXPECT_EQ(topology.component_of_face, (std::vector<uint32_t>{0, 0, 1}));
}

TEST(MeshTopology, WeldingEqualsBruteForceOnRandomPoints) {
  std::string text;
  uint32_t state = 1;
  const auto next = [&state] { return (state = state * 1664525u + 1013904223u) >> 8; };
  for (int i = 0; i < 600; ++i)  // a lattice with jitter far below and gaps far above the distance
    text += "v " + std::to_string(next() % 5 + 1e-6 * (next() % 3)) + " " + std::to_string(next() % 5) + " " +
            std::to_string(next() % 5) + "\n";
  for (int i = 0; i < 200; ++i)
    text += "f " + std::to_string(3 * i + 1) + " " + std::to_string(3 * i + 2) + " " +
            std::to_string(3 * i + 3) + "\n";
  const Scan scan = scan_of(text);
  const MeshTopology topology = mesh_topology(scan);
  for (size_t i = 0; i < scan.positions.size(); ++i)
    for (size_t j = 0; j < i; ++j)
      ASSERT_EQ(length(scan.positions[i] - scan.positions[j]) < 1e-3f,
                topology.point_of_position[i] == topology.point_of_position[j]);
}

TEST(ScanUnit, GuessesFromAHumansHeight) {
  EXPECT_EQ(resolve_unit_cm(scan_of(box_obj(1750)), std::nullopt), 0.1);
  EXPECT_EQ(resolve_unit_cm(scan_of(box_obj(175)), std::nullopt), 1.0);
  EXPECT_EQ(resolve_unit_cm(scan_of(box_obj(1.75)), std::nullopt), 100.0);
  EXPECT_EQ(resolve_unit_cm(scan_of(box_obj(69)), std::nullopt), 2.54);
  EXPECT_EQ(resolve_unit_cm(scan_of(box_obj(32)), std::string("cm")), 1.0);
}

TEST(ScanUnit, AsksWhereItCannotTell) {
  const auto message = [](const Scan& scan) {
    return input_error_of([&] { resolve_unit_cm(scan, std::nullopt); });
  };
  expect_message(message(scan_of(box_obj(32))), {"32", "--unit"});
  expect_message(message(scan_of(box_obj(175, "xzy"))), {"Z-up", "--up z", "Y up"});
  expect_message(message(scan_of(box_obj(175, "yxz"))), {"X-up", "--up", "Y up"});
  expect_message(input_error_of([] { unit_cm_of("ell"); }), {"ell", "inch"});
  Scan stated = scan_of(box_obj(17500));
  stated.stated_unit_cm = 1;
  expect_message(message(stated), {"states 1 cm", "--unit"});
  stated.stated_unit_cm = 0.01;
  EXPECT_EQ(resolve_unit_cm(stated, std::nullopt), 0.01);
}

}  // namespace
}  // namespace ohb
