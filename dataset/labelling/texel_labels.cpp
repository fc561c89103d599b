#include "dataset/labelling/texel_labels.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "dataset/labelling/class_pairs.h"
#include "dataset/labelling/face_features.h"
#include "dataset/labelling/texel_colours.h"
#include "dataset/labelling/texel_surface.h"

namespace ohb::labelling {
namespace {

constexpr float kLeastBand_cm = 0.3f,
                kMostBand_cm = 2;     // else the length of an edge: the most a border is off
constexpr double kFineEdge_cm = 0.1;  // a border along such edges is as good as one of texels
constexpr float kColour = 0.5f, kWay = 0.05f, kBorder_cm = 0.6f;
constexpr float kFloor = 0.01f;  // least probability
constexpr float kNever = 1e4f;   // cost of a class that a texel cannot have
constexpr float kLeastTexelLikeness = 0.2f;
constexpr int kSureStride = 3;  // of the texels beyond the band whose colours are gathered

struct Node {
  SurfaceTexel texel;
  uint32_t face;
  Vec3f point;           // cm
  ClassValues distance;  // to the faces' borders, in cm
  float area;            // cm2
};

}  // namespace

std::pair<int, int> class_map_size(const ScanMaterial& material) {
  if (material.diffuse.empty()) return {kClassMapWithoutPicture_px, kClassMapWithoutPicture_px};
  const ImageFileInfo picture = probe_image(material.diffuse);
  const double scale =
      std::min(1.0, double(kMaxClassMapEdge_px) / std::max(picture.width_px, picture.height_px));
  return {std::max(1, static_cast<int>(std::lround(picture.width_px * scale))),
          std::max(1, static_cast<int>(std::lround(picture.height_px * scale)))};
}

/// The steps of a refinement.
class TexelSolve {
 public:
  TexelSolve(const ScanSurface& scan_surface, TexelLabels& labels, const std::vector<bool>& fixed_faces)
      : scan_surface_(scan_surface),
        scan_(scan_surface.scan),
        labels_(labels),
        fixed_faces_(fixed_faces),
        pieces_(borders_of_faces(scan_surface, labels.face_class_)) {
    double weighed = 0;
    for (const BorderPiece& piece : pieces_) {
      const double edge = length(piece.b - piece.a);
      labels.summary_.border_cm += edge / 2;  // from both sides
      weighed += edge * edge / 2;
    }
    if (labels.summary_.border_cm > 0) labels.summary_.edge_cm = weighed / labels.summary_.border_cm;
  }

  void run(bool only_if_coarse) {
    TexelLabels::Summary& summary = labels_.summary_;
    labels_.classes_of_face_ = class_bits(labels_.face_class_);
    if (pieces_.empty()) {
      summary.reason = "no two classes share an edge of the mesh";
    } else if (only_if_coarse && summary.edge_cm <= kFineEdge_cm) {
      summary.reason = "the faces along the borders are small enough";
    } else {
      band_cm_ = std::clamp(static_cast<float>(summary.edge_cm), kLeastBand_cm, kMostBand_cm);
      summary.band_cm = band_cm_;
      solve();
    }
    collect_borders();
  }

 private:
  void solve() {
    BorderDistance::Reach reach;
    for (auto& row : reach) row.fill(2 * band_cm_);
    const BorderDistance distance(scan_surface_, pieces_, labels_.classes_of_face_, reach);
    std::vector<bool> is_near;
    for (uint32_t f = 0; f < scan_.face_count(); ++f) is_near.push_back(distance.is_near(f));
    surface_.emplace(scan_surface_, is_near);
    labels_.is_refined_.assign(scan_.face_count(), false);
    labels_.grids_.resize(scan_.materials.size());
    for (uint32_t s = 0; s < surface_->sheets().size(); ++s) add_nodes(s, distance);
    TexelLabels::Summary& summary = labels_.summary_;
    if (nodes_.empty()) {
      summary.reason = "no picture shows a border";
      return;
    }
    for (uint32_t f = 0; f < scan_.face_count(); ++f)
      labels_.is_refined_[f] = is_near[f] && labels_.grids_[scan_.face_material[f]].width > 0;
    colours_.fit();
    links_ = surface_->links();
    LabelEnergy energy = energy_of_texels();
    labels_.node_class_ = own_classes();
    minimise(energy, labels_.node_class_);
    if (forbid_where_nothing_shows(energy)) {
      labels_.node_class_ = own_classes();
      minimise(energy, labels_.node_class_);
    }
    drop_islands();
    double area = 0;
    for (size_t n = 0; n < nodes_.size(); ++n) {
      labels_.node_point_cm_.push_back(nodes_[n].point);
      labels_.node_edge_cm_.push_back(surface_->edge_cm_of(nodes_[n].texel));
      area += nodes_[n].area;
      if (labels_.node_class_[n] != labels_.face_class_[nodes_[n].face])
        summary.changed_cm2 += nodes_[n].area;
    }
    summary.is_refined = true;
    summary.texels = nodes_.size();
    summary.texel_cm = std::sqrt(area / static_cast<double>(nodes_.size()));
  }

  std::vector<uint8_t> own_classes() const {
    std::vector<uint8_t> own;
    for (const Node& node : nodes_) own.push_back(labels_.face_class_[node.face]);
    return own;
  }

  /// The texels in the band become nodes; those beyond tell what their class looks like.
  void add_nodes(uint32_t s, const BorderDistance& distance) {
    const TexelSurface::Sheet& sheet = surface_->sheets()[s];
    struct Row {
      std::vector<Node> nodes, sure;
    };
    std::vector<Row> rows(static_cast<size_t>(sheet.height));
    tbb::parallel_for(0, sheet.height, [&](int y) {
      for (int x = 0; x < sheet.width; ++x) {
        const SurfaceTexel texel{s, static_cast<uint32_t>(y * sheet.width + x)};
        if (!surface_->is_there(texel)) continue;
        Node node{
            texel, surface_->face_of(texel), surface_->point_of(texel), {}, surface_->area_cm2_of(texel)};
        node.distance = distance.distances_at(node.face, labels_.face_class_[node.face], node.point);
        const float nearest = *std::min_element(node.distance.begin(), node.distance.end());
        const bool is_fixed = !fixed_faces_.empty() && fixed_faces_[node.face];
        if (nearest < band_cm_ && !is_fixed) rows[y].nodes.push_back(node);
        if (nearest > 0.5f * band_cm_ && x % kSureStride == 0 && y % kSureStride == 0 && node.area > 0)
          rows[y].sure.push_back(node);
      }
    });
    TexelGrid& grid = labels_.grids_[sheet.material];
    grid.width = sheet.width;
    grid.height = sheet.height;
    grid.node.assign(static_cast<size_t>(sheet.width) * sheet.height, TexelGrid::kNone);
    sheet_grids_.push_back(&grid);
    for (const Row& row : rows) {
      for (const Node& node : row.nodes) {
        grid.node[node.texel.index] = static_cast<uint32_t>(nodes_.size());
        nodes_.push_back(node);
      }
      for (const Node& sure : row.sure)
        colours_.add(sure.point, labels_.face_class_[sure.face], surface_->lab_of(sure.texel), sure.area);
    }
  }

  uint32_t node_at(SurfaceTexel texel) const { return sheet_grids_[texel.sheet]->node[texel.index]; }
  uint8_t class_at(SurfaceTexel texel) const {
    const uint32_t node = node_at(texel);
    return node == TexelGrid::kNone ? labels_.face_class_[surface_->face_of(texel)]
                                    : labels_.node_class_[node];
  }

  LabelEnergy energy_of_texels() const {
    LabelEnergy energy;
    energy.distance = alike_distances();
    energy.cost.resize(nodes_.size());
    tbb::parallel_for(size_t{0}, nodes_.size(), [&](size_t n) {
      const Node& node = nodes_[n];
      const uint8_t own = labels_.face_class_[node.face];
      const ClassValues density = colours_.densities_at(node.point, own, surface_->lab_of(node.texel));
      const auto may_be = [&](uint8_t c) {
        return c == own || (density[c] > 0 && node.distance[c] < band_cm_);
      };
      float sum = 0;
      for (uint8_t c = 0; c < kClassCount; ++c) sum += may_be(c) ? density[c] : 0;
      for (uint8_t c = 0; c < kClassCount; ++c) {
        if (!may_be(c)) {
          energy.cost[n][c] = kNever;
          continue;
        }
        const float way = c == own ? 0 : node.distance[c] / band_cm_;
        const float probability = sum > 0 ? density[c] / sum : 1;
        energy.cost[n][c] = node.area * (kWay * way * way - kColour * std::log(probability + kFloor));
      }
    });
    std::vector<float> difference;
    for (const TexelLink& link : links_)
      difference.push_back(length(surface_->lab_of(link.texel[0]) - surface_->lab_of(link.texel[1])));
    const float median = median_difference(difference);
    for (size_t i = 0; i < links_.size(); ++i) {
      const TexelLink& link = links_[i];
      const uint32_t one = node_at(link.texel[0]), two = node_at(link.texel[1]);
      const float like = std::exp(-difference[i] * difference[i] / (2 * median * median));
      const float weight =
          kBorder_cm * length(link.b - link.a) * (kLeastTexelLikeness + (1 - kLeastTexelLikeness) * like);
      if (one != TexelGrid::kNone && two != TexelGrid::kNone) {
        energy.pairs.push_back({one, two, weight});
      } else if (one != TexelGrid::kNone || two != TexelGrid::kNone) {
        const int fixed = one == TexelGrid::kNone ? 0 : 1;
        const uint8_t beyond = labels_.face_class_[surface_->face_of(link.texel[fixed])];
        for (uint8_t c = 0; c < kClassCount; ++c)
          if (c != beyond) energy.cost[fixed ? one : two][c] += weight;
      }
    }
    return energy;
  }
  /// Shading that runs on over a border looks like two classes from afar. Where the colours close to both
  /// sides of the border that was found are alike, texels may not leave the class of their face. True if some
  /// did.
  bool forbid_where_nothing_shows(LabelEnergy& energy) const {
    constexpr int kFirstRing = 2, kLastRing = 4;  // of texels from the border; nearer ones are mixtures
    std::vector<uint8_t> ring(nodes_.size(), 255);
    for (const TexelLink& link : links_)
      if (class_at(link.texel[0]) != class_at(link.texel[1]))
        for (const SurfaceTexel& texel : link.texel)
          if (node_at(texel) != TexelGrid::kNone) ring[node_at(texel)] = 0;
    for (uint8_t from = 0; from < kLastRing; ++from)
      for (const EnergyPair& pair : energy.pairs)
        for (const auto& [a, b] : {std::pair(pair.a, pair.b), std::pair(pair.b, pair.a)})
          if (ring[a] == from && ring[b] == 255 && labels_.node_class_[a] == labels_.node_class_[b])
            ring[b] = static_cast<uint8_t>(from + 1);
    LocalColours beside;
    for (size_t n = 0; n < nodes_.size(); ++n)
      if (ring[n] >= kFirstRing && ring[n] <= kLastRing && nodes_[n].area > 0)
        beside.add(nodes_[n].point, labels_.node_class_[n], surface_->lab_of(nodes_[n].texel),
                   nodes_[n].area);
    beside.fit();
    bool has_some = false;
    for (size_t n = 0; n < nodes_.size(); ++n) {
      const uint8_t own = labels_.face_class_[nodes_[n].face];
      for (uint8_t c = 0; c < kClassCount; ++c) {
        if (c == own || beside.can_tell(nodes_[n].point, own, c)) continue;
        energy.cost[n][c] = kNever;
        has_some = has_some || labels_.node_class_[n] == c;
      }
    }
    return has_some;
  }

  /// A border that moves takes no islands: texels that left their face's class and that no way over texels of
  /// their new class connects with a face of that class (nostrils in the colour of hair) go back.
  void drop_islands() {
    DisjointSets sets(nodes_.size() + kClassCount);  // the last stand for what already was of each class
    const auto ground = [&](uint8_t c) { return static_cast<uint32_t>(nodes_.size()) + c; };
    for (uint32_t n = 0; n < nodes_.size(); ++n)
      if (labels_.node_class_[n] == labels_.face_class_[nodes_[n].face])
        sets.join(n, ground(labels_.node_class_[n]));
    for (const TexelLink& link : links_) {
      const uint8_t one = class_at(link.texel[0]), two = class_at(link.texel[1]);
      if (one != two) continue;
      const uint32_t a = node_at(link.texel[0]), b = node_at(link.texel[1]);
      if (a == TexelGrid::kNone && b == TexelGrid::kNone) continue;
      sets.join(a == TexelGrid::kNone ? ground(one) : a, b == TexelGrid::kNone ? ground(one) : b);
    }
    for (uint32_t n = 0; n < nodes_.size(); ++n)
      if (sets.find(n) != sets.find(ground(labels_.node_class_[n])))
        labels_.node_class_[n] = labels_.face_class_[nodes_[n].face];
  }

  void collect_borders() {
    for (size_t n = 0; n < labels_.node_class_.size(); ++n)
      labels_.classes_of_face_[nodes_[n].face] |= static_cast<uint8_t>(1u << labels_.node_class_[n]);
    if (!labels_.summary_.is_refined) {
      labels_.is_refined_.clear();
      labels_.borders_ = std::move(pieces_);
      return;
    }
    for (const BorderPiece& piece : pieces_)
      if (!labels_.is_refined_[piece.face] || !labels_.is_refined_[piece.beyond])
        labels_.borders_.push_back(piece);
    for (const TexelLink& link : links_) {
      const uint8_t one = class_at(link.texel[0]), two = class_at(link.texel[1]);
      if (one == two) continue;
      const uint32_t one_face = surface_->face_of(link.texel[0]), two_face = surface_->face_of(link.texel[1]);
      labels_.borders_.push_back({one_face, two_face, one, two, link.a, link.b});
      labels_.borders_.push_back({two_face, one_face, two, one, link.a, link.b});
    }
  }

  const ScanSurface& scan_surface_;
  const Scan& scan_;
  TexelLabels& labels_;
  const std::vector<bool>& fixed_faces_;
  std::vector<BorderPiece> pieces_;
  float band_cm_ = 0;
  std::optional<TexelSurface> surface_;
  std::vector<const TexelGrid*> sheet_grids_;
  std::vector<Node> nodes_;
  std::vector<TexelLink> links_;
  LocalColours colours_;
};

TexelLabels::TexelLabels(const ScanSurface& surface, const std::vector<uint8_t>& face_class,
                         const std::vector<bool>& fixed_faces, bool only_if_coarse)
    : face_class_(face_class) {
  TexelSolve(surface, *this, fixed_faces).run(only_if_coarse);
}

uint8_t TexelLabels::class_at(size_t material, uint32_t face, double x, double y, Vec3f point_cm) const {
  if (!is_refined(face)) return face_class_[face];
  const TexelGrid& grid = grids_[material];
  const auto index = [](double share, int size) {
    return std::clamp(static_cast<int>(share * size), 0, size - 1);
  };
  const uint32_t node =
      grid.node[static_cast<size_t>(index(y, grid.height)) * grid.width + index(x, grid.width)];
  if (node == TexelGrid::kNone) return face_class_[face];
  // Where charts lie close in a coarser grid the texel may be of the other one.
  return length(node_point_cm_[node] - point_cm) <= 3 * node_edge_cm_[node] ? node_class_[node]
                                                                            : face_class_[face];
}

}  // namespace ohb::labelling
