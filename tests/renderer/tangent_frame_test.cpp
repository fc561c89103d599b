// Our MikkTSpace against Blender's, corner by corner.
#include "dataset/model/tangent_frame.h"
#include "tests/support/paths.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <random>
#include <string>

namespace ohb {
namespace {

namespace fs = std::filesystem;

template <class T>
void write_raw(const fs::path& file, const std::vector<T>& values) {
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(values.data()),
             static_cast<std::streamsize>(values.size() * sizeof(T)));
}

template <class T>
std::vector<T> read_raw(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  std::vector<T> values(static_cast<size_t>(std::max<std::streamoff>(stream.tellg(), 0)) / sizeof(T));
  stream.seekg(0);
  stream.read(reinterpret_cast<char*>(values.data()),
              static_cast<std::streamsize>(values.size() * sizeof(T)));
  return values;
}

void add_triangle(Model& model, const std::array<uint32_t, 3>& position, const std::array<uint32_t, 3>& uv) {
  ModelTriangle triangle{};
  std::copy(position.begin(), position.end(), triangle.position);
  std::copy(uv.begin(), uv.end(), triangle.uv);
  model.triangles.push_back(triangle);
}

/// A wavy n x n grid of quads, two triangles each; one UV a position, mapped by `uv_of`.
Model wavy_grid(int n, const std::function<Vec2f(float, float)>& uv_of) {
  Model model;
  std::mt19937 random(7);
  std::uniform_real_distribution<float> jitter(-0.3f, 0.3f);
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) {
      const float u = static_cast<float>(x) / n, v = static_cast<float>(y) / n;
      model.positions_cm.push_back({x + jitter(random), y + jitter(random), 2 * std::sin(3 * u + 5 * v)});
      model.uvs.push_back(uv_of(u, v));
    }
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const uint32_t a = y * (n + 1) + x, b = a + 1, c = a + n + 1, d = c + 1;
      add_triangle(model, {a, b, d}, {a, b, d});
      add_triangle(model, {a, d, c}, {a, d, c});
    }
  return model;
}

Model mirrored() {
  return wavy_grid(8, [](float u, float v) { return Vec2f{std::fabs(u - 0.5f), v + 0.2f * u}; });
}

/// Every quad is an island of its own, turned at random, some mirrored.
Model seams() {
  Model model = wavy_grid(8, [](float, float) { return Vec2f{}; });
  model.uvs.clear();
  std::mt19937 random(11);
  std::uniform_real_distribution<float> any(0, 1);
  for (size_t t = 0; t + 1 < model.triangles.size(); t += 2) {
    const float angle = 6.2831853f * any(random), flip = any(random) < 0.3f ? -1.0f : 1.0f;
    const Vec2f across{std::cos(angle), std::sin(angle)}, up{-across.y * flip, across.x * flip};
    const uint32_t first = static_cast<uint32_t>(model.uvs.size());
    for (Vec2f uv : {Vec2f{0, 0}, across, across + up, up}) model.uvs.push_back(uv);
    const uint32_t corners[2][3] = {{first, first + 1, first + 2}, {first, first + 2, first + 3}};
    for (int k = 0; k < 2; ++k) std::copy(corners[k], corners[k] + 3, model.triangles[t + k].uv);
  }
  return model;
}

/// Long thin triangles in space and in UV, and some collinear ones.
Model slivers() {
  Model model = wavy_grid(10, [](float u, float v) { return Vec2f{u, v}; });
  for (size_t i = 0; i < model.positions_cm.size(); ++i)
    if (i / 11 % 3 == 1) model.positions_cm[i] = model.positions_cm[i - 11] + Vec3f{1e-4f, 1e-4f, 2e-4f};
  for (size_t i = 0; i < model.uvs.size(); ++i)
    if (i / 11 % 4 == 2) model.uvs[i].y = model.uvs[i - 11].y + 1e-5f;
  return model;
}

/// Patches without UV area inside, at the border of, and apart from, good ones.
Model zero_uv_area() {
  Model model = wavy_grid(9, [](float u, float v) {
    const bool flat = (u > 0.3f && u < 0.6f && v > 0.3f && v < 0.7f) || v > 0.85f;
    return flat ? Vec2f{0.5f, 0.5f} : Vec2f{std::fabs(u - 0.4f), v};
  });
  const uint32_t first = static_cast<uint32_t>(model.positions_cm.size());
  for (Vec3f p : {Vec3f{20, 0, 0}, Vec3f{21, 0, 0.5f}, Vec3f{20, 1, 0}}) {
    model.positions_cm.push_back(p);
    model.uvs.push_back({0.25f, 0.25f});
  }
  add_triangle(model, {first, first + 1, first + 2}, {first, first + 1, first + 2});
  return model;
}

/// Triangles with two corners at one place (distinct vertices), next to good ones.
Model zero_area() {
  Model model = wavy_grid(6, [](float u, float v) { return Vec2f{u, v * v}; });
  model.positions_cm[8] = model.positions_cm[9];
  model.positions_cm[24] = model.positions_cm[31];
  return model;
}

/// Three triangles on an edge, a two-sided sheet and a bow-tie vertex.
Model non_manifold() {
  Model model = wavy_grid(4, [](float u, float v) { return Vec2f{u, v}; });
  const uint32_t first = static_cast<uint32_t>(model.positions_cm.size());
  model.positions_cm.push_back({2, 2, 9});
  model.uvs.push_back({0.1f, 0.9f});
  add_triangle(model, {6, 7, first}, {6, 7, first});
  add_triangle(model, {7, 6, first}, {7, 6, first});
  add_triangle(model, {12, 18, first}, {12, 18, first});
  return model;
}

/// Corners of an OBJ of MakeHuman parts, polygons cut as fans.
Model read_parts(const fs::path& file) {
  Model model;
  std::ifstream stream(file);
  std::string line;
  while (std::getline(stream, line)) {
    Vec3f p;
    Vec2f t;
    if (std::sscanf(line.c_str(), "v %f %f %f", &p.x, &p.y, &p.z) == 3) model.positions_cm.push_back(p);
    if (std::sscanf(line.c_str(), "vt %f %f", &t.x, &t.y) == 2) model.uvs.push_back(t);
    uint32_t v[4], w[4];
    const int read = std::sscanf(line.c_str(), "f %u/%u %u/%u %u/%u %u/%u", v, w, v + 1, w + 1, v + 2, w + 2,
                                 v + 3, w + 3);
    for (int k = 2; k < read / 2; ++k)
      add_triangle(model, {v[0] - 1, v[k - 1] - 1, v[k] - 1}, {w[0] - 1, w[k - 1] - 1, w[k] - 1});
  }
  return model;
}

struct Case {
  std::string name;
  Model model;
};

void write_case(const fs::path& folder, const Model& model) {
  fs::create_directories(folder);
  std::vector<uint32_t> triangles;
  std::vector<Vec2f> corner_uvs;
  for (const ModelTriangle& triangle : model.triangles)
    for (int i = 0; i < 3; ++i) {
      triangles.push_back(triangle.position[i]);
      corner_uvs.push_back(model.uvs[triangle.uv[i]]);
    }
  write_raw(folder / "positions.f32", model.positions_cm);
  write_raw(folder / "triangles.u32", triangles);
  write_raw(folder / "corner_uvs.f32", corner_uvs);
}

struct BlenderTangent {
  float x, y, z, sign;
};

void compare(const Case& test, const fs::path& folder) {
  const auto normals = read_raw<Vec3f>(folder / "normals.f32");
  const auto expected = read_raw<BlenderTangent>(folder / "tangents.f32");
  ASSERT_EQ(normals.size(), test.model.positions_cm.size()) << test.name;
  ASSERT_EQ(expected.size(), 3 * test.model.triangles.size()) << test.name;
  const auto tangents = mikktspace_tangents(test.model, normals);
  ASSERT_EQ(tangents.size(), expected.size());
  size_t wrong = 0, first_wrong = 0;
  float worst = 0;
  for (size_t c = 0; c < expected.size(); ++c) {
    const Vec3f difference = tangents[c].tangent - Vec3f{expected[c].x, expected[c].y, expected[c].z};
    const float error = length(difference);
    worst = std::max(worst, error);
    const bool good = error <= 1e-4f && tangents[c].sign == expected[c].sign;
    if (!good && wrong++ == 0) first_wrong = c;
  }
  const auto& ours = tangents[first_wrong];
  const auto& theirs = expected[first_wrong];
  EXPECT_EQ(wrong, 0u) << test.name << ": of " << expected.size() << " corners, worst " << worst
                       << ", first corner " << first_wrong << ": " << ours.tangent.x << " " << ours.tangent.y
                       << " " << ours.tangent.z << " (" << ours.sign << ") not " << theirs.x << " "
                       << theirs.y << " " << theirs.z << " (" << theirs.sign << ")";
}

TEST(TangentFrame, EqualsBlender) {
  std::vector<Case> cases = {{"mirrored", mirrored()},   {"seams", seams()},
                             {"slivers", slivers()},     {"zero_uv_area", zero_uv_area()},
                             {"zero_area", zero_area()}, {"non_manifold", non_manifold()}};
  for (const char* name : {"m48_suit", "f25_casual"}) {
    const fs::path file = fs::path(shared_data_path("humans")) / name / (std::string(name) + ".obj");
    if (fs::exists(file)) cases.push_back({name, read_parts(file)});
  }
  const fs::path folder = fs::path(testing::TempDir()) / "ohb_tangents";
  fs::remove_all(folder);
  std::string command = "blender -b -noaudio --factory-startup --python-exit-code 1 --python '" +
                        source_path("tests/renderer/dump_tangents.py") + "' --";
  for (const Case& test : cases) {
    write_case(folder / test.name, test.model);
    command += " '" + (folder / test.name).string() + "'";
  }
  ASSERT_EQ(std::system((command + " > '" + (folder / "log").string() + "' 2>&1").c_str()), 0) << command;
  for (const Case& test : cases) compare(test, folder / test.name);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace ohb
