#include "dataset/model/tangent_frame.h"

#include <algorithm>
#include <array>
#include <cfloat>
#include <cstring>
#include <unordered_map>

// Own implementation from the published description: Mikkelsen, "Simulation of Wrinkled Surfaces Revisited"
// (2008), section 2.5 and appendix, and the rules that his reference states in words. In short: corners
// are welded; triangles of one UV orientation that share edges around a welded vertex form a group; the
// group's tangent is the sum of its triangles' tangents in the vertex's plane, weighted by corner angle.

namespace ohb {
namespace {

constexpr uint32_t kNone = 0xffffffffu;

bool not_zero(float value) {
  return std::fabs(value) > FLT_MIN;
}

/// v in the plane of n, as a unit vector where something of it remains.
Vec3f project(Vec3f n, Vec3f v) {
  const Vec3f in_plane = v - dot(n, v) * n;
  const float size = length(in_plane);
  return not_zero(size) ? in_plane * (1.0f / size) : in_plane;
}

struct Triangle {
  std::array<uint32_t, 3> vertex{};                          // welded
  std::array<uint32_t, 3> neighbour{{kNone, kNone, kNone}};  // across the edge from corner i to i + 1
  std::array<uint32_t, 3> group{{kNone, kNone, kNone}};
  Vec3f tangent;                // along rising u, unit length
  bool degenerate = false;      // two corners at one place
  bool groups_with_any = true;  // no UV area: takes any orientation
  bool preserves_orientation = false;
};

struct Group {
  uint32_t vertex = 0;
  bool preserves_orientation = false;
  Vec3f tangent;  // sum, then unit length
};

/// Position, normal and UV of a corner: what welds corners where all of it is equal.
struct Key {
  std::array<float, 8> values;
  bool operator==(const Key& other) const { return values == other.values; }
};

struct KeyHash {
  size_t operator()(const Key& key) const {
    uint64_t hash = 1469598103934665603ull;
    for (float value : key.values) {
      value += 0.0f;  // -0 equals 0
      uint32_t bits;
      std::memcpy(&bits, &value, sizeof bits);
      hash = (hash ^ bits) * 1099511628211ull;
      hash ^= hash >> 29;
    }
    return static_cast<size_t>(hash);
  }
};

bool same(Vec3f a, Vec3f b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}

class TangentSpace {
 public:
  TangentSpace(const Model& model, const std::vector<Vec3f>& normals)
      : model_(model), normals_(normals), triangles_(model.triangles.size()) {}

  std::vector<CornerTangent> compute() {
    weld();
    for (size_t t = 0; t < triangles_.size(); ++t) classify(t);
    link_neighbours();
    build_groups();
    sum_tangents();
    return corners();
  }

 private:
  Vec3f position(size_t t, int corner) const {
    return model_.positions_cm[model_.triangles[t].position[corner]];
  }
  Vec3f normal(size_t t, int corner) const { return normals_[model_.triangles[t].position[corner]]; }
  Vec2f uv(size_t t, int corner) const { return model_.uvs[model_.triangles[t].uv[corner]]; }

  void weld() {
    std::unordered_map<Key, uint32_t, KeyHash> vertices;
    vertices.reserve(triangles_.size());
    for (size_t t = 0; t < triangles_.size(); ++t)
      for (int i = 0; i < 3; ++i) {
        const Vec3f p = position(t, i), n = normal(t, i);
        const Vec2f st = uv(t, i);
        const Key key{{p.x, p.y, p.z, n.x, n.y, n.z, st.x, st.y}};
        triangles_[t].vertex[i] = vertices.emplace(key, static_cast<uint32_t>(vertices.size())).first->second;
      }
  }

  /// First-order derivative of position by u (Mikkelsen 2008, eq. 18), orientation and usefulness.
  void classify(size_t t) {
    Triangle& triangle = triangles_[t];
    const Vec3f p0 = position(t, 0), p1 = position(t, 1), p2 = position(t, 2);
    triangle.degenerate = same(p0, p1) || same(p1, p2) || same(p2, p0);
    if (triangle.degenerate) return;
    const Vec2f st1 = uv(t, 1) - uv(t, 0), st2 = uv(t, 2) - uv(t, 0);
    const Vec3f d1 = p1 - p0, d2 = p2 - p0;
    const float area = cross(st1, st2);
    const Vec3f along_u = st2.y * d1 - st1.y * d2, along_v = st1.x * d2 - st2.x * d1;
    triangle.preserves_orientation = area > 0;
    if (!not_zero(area)) return;
    const float size_u = length(along_u), size_v = length(along_v);
    if (not_zero(size_u)) triangle.tangent = along_u * ((area > 0 ? 1.0f : -1.0f) / size_u);
    triangle.groups_with_any = !(not_zero(size_u) && not_zero(size_v));
  }

  struct Edge {
    uint32_t low, high, triangle;
    uint8_t corner;  // the edge goes from this corner to the next
    bool rising;     // from low to high
    bool operator<(const Edge& other) const {
      if (low != other.low) return low < other.low;
      if (high != other.high) return high < other.high;
      if (triangle != other.triangle) return triangle < other.triangle;
      return corner < other.corner;
    }
  };

  std::vector<Edge> sorted_edges() const {
    std::vector<Edge> edges;
    edges.reserve(triangles_.size() * 3);
    for (uint32_t t = 0; t < triangles_.size(); ++t) {
      if (triangles_[t].degenerate) continue;
      for (uint8_t i = 0; i < 3; ++i) {
        const uint32_t a = triangles_[t].vertex[i], b = triangles_[t].vertex[(i + 1) % 3];
        edges.push_back({std::min(a, b), std::max(a, b), t, i, a < b});
      }
    }
    std::sort(edges.begin(), edges.end());
    return edges;
  }

  /// Each edge is linked with the first free one of opposite direction between the same two vertices.
  void link_neighbours() {
    const std::vector<Edge> edges = sorted_edges();
    for (size_t e = 0; e < edges.size(); ++e) {
      const Edge& a = edges[e];
      if (triangles_[a.triangle].neighbour[a.corner] != kNone) continue;
      for (size_t f = e + 1; f < edges.size() && edges[f].low == a.low && edges[f].high == a.high; ++f) {
        const Edge& b = edges[f];
        if (a.rising == b.rising || triangles_[b.triangle].neighbour[b.corner] != kNone) continue;
        triangles_[a.triangle].neighbour[a.corner] = b.triangle;
        triangles_[b.triangle].neighbour[b.corner] = a.triangle;
        break;
      }
    }
  }

  int corner_of(const Triangle& triangle, uint32_t vertex) const {
    return triangle.vertex[0] == vertex ? 0 : triangle.vertex[1] == vertex ? 1 : 2;
  }

  void build_groups() {
    for (uint32_t t = 0; t < triangles_.size(); ++t) {
      if (triangles_[t].degenerate || triangles_[t].groups_with_any) continue;
      for (int i = 0; i < 3; ++i) {
        if (triangles_[t].group[i] != kNone) continue;
        groups_.push_back({triangles_[t].vertex[i], triangles_[t].preserves_orientation, {}});
        triangles_[t].group[i] = static_cast<uint32_t>(groups_.size() - 1);
        grow_group(t, i);
      }
    }
  }

  void push_neighbours(const Triangle& triangle, int corner) {
    stack_.push_back(triangle.neighbour[(corner + 2) % 3]);
    stack_.push_back(triangle.neighbour[corner]);  // taken first
  }

  /// Walks the fan of triangles around the newest group's vertex, starting beside triangle t.
  void grow_group(uint32_t t, int corner) {
    const uint32_t id = static_cast<uint32_t>(groups_.size() - 1);
    const Group& group = groups_.back();
    push_neighbours(triangles_[t], corner);
    while (!stack_.empty()) {
      const uint32_t next = stack_.back();
      stack_.pop_back();
      if (next == kNone) continue;
      Triangle& triangle = triangles_[next];
      const int i = corner_of(triangle, group.vertex);
      if (triangle.group[i] != kNone) continue;
      const bool free =
          triangle.group[0] == kNone && triangle.group[1] == kNone && triangle.group[2] == kNone;
      if (triangle.groups_with_any && free) triangle.preserves_orientation = group.preserves_orientation;
      if (triangle.preserves_orientation != group.preserves_orientation) continue;
      triangle.group[i] = id;
      push_neighbours(triangle, i);
    }
  }

  void sum_tangents() {
    for (size_t t = 0; t < triangles_.size(); ++t) {
      const Triangle& triangle = triangles_[t];
      if (triangle.degenerate || triangle.groups_with_any) continue;
      for (int i = 0; i < 3; ++i) {
        const Vec3f n = normal(t, i), p = position(t, i);
        const float cosine =
            dot(project(n, position(t, (i + 1) % 3) - p), project(n, position(t, (i + 2) % 3) - p));
        const float angle = std::acos(std::clamp(cosine, -1.0f, 1.0f));
        groups_[triangle.group[i]].tangent += angle * project(n, triangle.tangent);
      }
    }
    for (Group& group : groups_) {
      const float size = length(group.tangent);
      if (not_zero(size)) group.tangent *= 1.0f / size;
    }
  }

  CornerTangent of_group(uint32_t group) const {
    if (group == kNone) return {{1, 0, 0}, -1};
    return {groups_[group].tangent, groups_[group].preserves_orientation ? 1.0f : -1.0f};
  }

  /// Degenerate triangles borrow from the first good corner of the same welded vertex.
  std::vector<CornerTangent> corners() const {
    std::unordered_map<uint32_t, uint32_t> group_of_vertex;
    std::vector<CornerTangent> result(triangles_.size() * 3);
    for (size_t t = 0; t < triangles_.size(); ++t) {
      if (triangles_[t].degenerate) continue;
      for (int i = 0; i < 3; ++i) {
        result[3 * t + i] = of_group(triangles_[t].group[i]);
        group_of_vertex.emplace(triangles_[t].vertex[i], triangles_[t].group[i]);
      }
    }
    for (size_t t = 0; t < triangles_.size(); ++t) {
      if (!triangles_[t].degenerate) continue;
      for (int i = 0; i < 3; ++i) {
        const auto found = group_of_vertex.find(triangles_[t].vertex[i]);
        result[3 * t + i] = of_group(found == group_of_vertex.end() ? kNone : found->second);
      }
    }
    return result;
  }

  const Model& model_;
  const std::vector<Vec3f>& normals_;
  std::vector<Triangle> triangles_;
  std::vector<Group> groups_;
  std::vector<uint32_t> stack_;
};

}  // namespace

std::vector<CornerTangent> mikktspace_tangents(const Model& model, const std::vector<Vec3f>& normals) {
  return TangentSpace(model, normals).compute();
}

}  // namespace ohb
