#include "bake/seam_agree.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "bake/seam_mend.h"
#include "bake/seam_places.h"
#include "bake/seam_values.h"

namespace ohb::bake {
namespace {

/// How much more a texel inside a triangle resists than one of the background.
constexpr double kInsideHold = 10;
/// Of a texel that ran into the border of [0,1], in what it resists otherwise; more each time.
constexpr double kBorderHold = 100, kMoreBorderHold = 4;
/// Where seams read more of the texels inside triangles than this, agreement would leave nothing of the map.
constexpr double kMostRead = 2.0 / 3;

/// What sweeps leave alone.
constexpr float kSweptColours = 0.25f / 255, kSweptNormals = 0.004f;

/// What is asked of places, in limits: first so little that no quadratic between them rises above the limit;
/// of the few that are left after some windows less strictly, since the points between are looked at too.
constexpr float kAsked = 1 / kQuadraticOvershoot, kAskedLater = 0.9f, kAskedBetween = 0.95f;
constexpr int kStrictWindows = 3;
/// Solutions aim at less than what is asked, so that weights come to rest.
constexpr float kAim = 0.94f * kAsked;
/// The power of a place's distance, in aims, that its weight is multiplied by, and the bounds of that factor.
constexpr double kPower = 1.5, kMostDecay = 0.6, kMostGrowth = 8, kLeastWeight = 1e-3;

constexpr int kSolves = 8;       // of one window
constexpr int kWindows = 12;     // one after the other
constexpr int kReach = 2;        // of the first window, in places; twice that every other time
constexpr int kRefinements = 4;  // times that points between become places

std::vector<Vec3f> read_texels(const Image& map, const std::vector<uint32_t>& texels) {
  std::vector<Vec3f> values(texels.size());
  for (size_t t = 0; t < texels.size(); ++t)
    for (int c = 0; c < map.channels; ++c) values[t][c] = map.values[size_t{texels[t]} * map.channels + c];
  return values;
}

void write_texels(Image& map, const std::vector<uint32_t>& texels, const std::vector<Vec3f>& values) {
  for (size_t t = 0; t < texels.size(); ++t)
    for (int c = 0; c < map.channels; ++c) map.values[size_t{texels[t]} * map.channels + c] = values[t][c];
}

SideValues values_at(const SeamPlace& place, const std::vector<Vec3f>& texels) {
  SideValues value;
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 4; ++j) value[k] += place.weight[k][j] * texels[place.texel[k][j]];
  return value;
}

template <typename Values>
class Agreement {
 public:
  Agreement(const SeamPlaces& places, const Values& values, std::vector<Vec3f>& texels,
            std::vector<double> hold)
      : places_(places.places),
        all_(places),
        values_(values),
        texels_(texels),
        hold_(std::move(hold)),
        border_hold_(texels.size()),
        apart_(places_.size()),
        weight_(places_.size()) {}

  /// Gives how many places stay beyond the limit.
  size_t run() {
    size_t beyond = measure();
    for (int window = 0; window < kWindows && beyond > 0; ++window) {
      mend_window(kReach << (window / 2));
      if (window + 1 == kStrictWindows) asked_ = kAskedLater;
      beyond = measure();
    }
    return std::count_if(apart_.begin(), apart_.end(), [](float apart) { return !(apart <= 1); });
  }

 private:
  using System = typename Values::System;
  using Row = typename System::Row;
  static constexpr uint32_t kNone = System::kNone;

  /// The texels that a window changes, and the places that read any of them.
  struct Window {
    std::vector<uint32_t> texels, places;
    std::vector<Row> rows;      // of the places
    std::vector<Vec3f> before;  // of the texels
  };

  bool is_beyond(size_t place) const { return !(apart_[place] <= asked_); }

  void measure(size_t place) {
    apart_[place] =
        values_.apart(places_[place].seam, places_[place].along, values_at(places_[place], texels_));
  }
  /// All places; gives how many are beyond what is asked.
  size_t measure() {
    tbb::parallel_for(size_t{0}, apart_.size(), [&](size_t p) { measure(p); });
    size_t count = 0;
    for (size_t p = 0; p < apart_.size(); ++p) count += is_beyond(p);
    return count;
  }

  /// The texels from which a place beyond the limit is less than so many places away, ascending.
  std::vector<uint32_t> texels_near(int reach) const {
    std::vector<uint8_t> is_near(texels_.size()), is_reached(places_.size());
    std::vector<uint32_t> places, texels;
    for (uint32_t p = 0; p < places_.size(); ++p)
      if (is_beyond(p)) {
        places.push_back(p);
        is_reached[p] = 1;
      }
    for (int step = 0; step < reach; ++step) {
      const size_t first = texels.size();
      for (uint32_t p : places)
        for (const auto& side : places_[p].texel)
          for (uint32_t t : side) {
            if (!is_near[t]) texels.push_back(t);
            is_near[t] = 1;
          }
      places.clear();
      for (size_t i = first; i < texels.size(); ++i)
        for (uint32_t r = all_.first_read[texels[i]]; r < all_.first_read[texels[i] + 1]; ++r) {
          if (!is_reached[all_.reads[r]]) places.push_back(all_.reads[r]);
          is_reached[all_.reads[r]] = 1;
        }
    }
    std::sort(texels.begin(), texels.end());
    return texels;
  }

  Window window_of(std::vector<uint32_t> texels) const {
    Window window;
    std::vector<uint32_t> unknown_of(texels_.size(), kNone);
    for (uint32_t u = 0; u < texels.size(); ++u) {
      unknown_of[texels[u]] = u;
      window.before.push_back(texels_[texels[u]]);
    }
    window.texels = std::move(texels);
    for (uint32_t p = 0; p < places_.size(); ++p) {
      std::array<uint32_t, 8> unknown;
      for (int i = 0; i < 8; ++i) unknown[i] = unknown_of[places_[p].texel[i / 4][i % 4]];
      if (std::all_of(unknown.begin(), unknown.end(), [](uint32_t u) { return u == kNone; })) continue;
      window.rows.emplace_back();
      window.rows.back().unknown = unknown;
      window.places.push_back(p);
    }
    return window;
  }

  void mend_window(int reach) {
    Window window = window_of(texels_near(reach));
    System system(static_cast<uint32_t>(window.texels.size()), window.rows);
    const double before = excess(window);
    for (int solve = 0; solve < kSolves && excess(window) > 0; ++solve) {
      update_rows(window);
      change_texels(window, system.solve(window.rows, texels_of(window)));
      for (uint32_t p : window.places) measure(p);
    }
    if (Values::kCanStray && excess(window) > before) return_from_stray(window);
  }

  /// Sum over the places of how far they are beyond what is asked.
  double excess(const Window& window) const {
    double sum = 0;
    for (uint32_t p : window.places)
      if (is_beyond(p)) sum += apart_[p] - asked_;
    return sum;
  }

  void return_from_stray(const Window& window) {
    for (size_t u = 0; u < window.texels.size(); ++u) texels_[window.texels[u]] = window.before[u];
    for (uint32_t p : window.places) {
      measure(p);
      weight_[p] = 0;
    }
    for (uint32_t t : texels_near(1)) Values::calm(texels_[t]);
  }

  void update_rows(Window& window) {
    tbb::parallel_for(size_t{0}, window.rows.size(), [&](size_t r) {
      const uint32_t p = window.places[r];
      const SideValues value = values_at(places_[p], texels_);
      const double over = apart_[p] / kAim;
      const double factor = std::clamp(std::pow(over, kPower), kMostDecay, kMostGrowth);
      weight_[p] =
          weight_[p] == 0 ? values_.first_weight(value) : std::max(kLeastWeight, factor * weight_[p]);
      window.rows[r].weight = weight_[p];
      values_.linearise(places_[p], value, texels_, window.rows[r]);
    });
  }

  std::vector<typename System::Texel> texels_of(const Window& window) const {
    std::vector<typename System::Texel> texels(window.texels.size());
    tbb::parallel_for(size_t{0}, texels.size(), [&](size_t u) {
      const uint32_t t = window.texels[u];
      texels[u].hold = hold_[t] * (1 + border_hold_[t]);
      texels[u].pull = Values::back(texels_[t], window.before[u]);
      for (double& pull : texels[u].pull) pull *= hold_[t];
    });
    return texels;
  }

  void change_texels(const Window& window, const std::vector<typename System::Value>& changes) {
    tbb::parallel_for(size_t{0}, changes.size(), [&](size_t u) {
      const uint32_t t = window.texels[u];
      if (Values::change(texels_[t], changes[u]))
        border_hold_[t] = std::max(kBorderHold, kMoreBorderHold * border_hold_[t]);
    });
  }

  const std::vector<SeamPlace>& places_;
  const SeamPlaces& all_;
  const Values& values_;
  std::vector<Vec3f>& texels_;
  const std::vector<double> hold_;
  std::vector<double> border_hold_;  // in hold_; 0: never ran into a border
  float asked_ = kAsked;
  std::vector<float> apart_;    // of each place, in limits
  std::vector<double> weight_;  // of each place; 0: in no window yet
};

/// Points between neighbouring places at which the sides are too far apart.
template <typename Values>
std::vector<SeamPoint> points_beyond(const Image& map, const std::vector<Seam>& seams,
                                     const std::vector<SeamPlace>& places, const Values& values) {
  constexpr int kPoints = Values::kPointsBetween;
  std::vector<std::array<float, kPoints>> beyond(places.size());  // along; 0: none
  tbb::parallel_for(size_t{1}, places.size(), [&](size_t p) {
    const SeamPlace &from = places[p - 1], &to = places[p];
    if (from.seam != to.seam) return;
    for (int i = 0; i < kPoints; ++i) {
      const float along = from.along + (to.along - from.along) * static_cast<float>(i + 1) / (kPoints + 1);
      SideValues value;
      for (int k = 0; k < 2; ++k) {
        const SeamLookup lookup = lookup_at(seams[to.seam].side[k], along, 0, map.width_px, map.height_px);
        for (int j = 0; j < 4; ++j)
          for (int c = 0; c < map.channels; ++c)
            value[k][c] +=
                lookup.weight[j / 2][j % 2] * map.pixel(lookup.column[j % 2], lookup.row[j / 2])[c];
      }
      if (!(values.apart(to.seam, along, value) <= kAskedBetween)) beyond[p][i] = along;
    }
  });
  std::vector<SeamPoint> points;
  for (size_t p = 0; p < places.size(); ++p)
    for (float along : beyond[p])
      if (along > 0) points.emplace_back(places[p].seam, along);
  return points;
}

std::vector<double> hold_of(const std::vector<uint32_t>& texels, const std::vector<uint8_t>& is_inside) {
  std::vector<double> hold(texels.size());
  for (size_t t = 0; t < hold.size(); ++t) hold[t] = is_inside[texels[t]] ? kInsideHold : 1;
  return hold;
}

bool reads_most(const std::vector<uint32_t>& texels, const std::vector<uint8_t>& is_inside) {
  const auto read =
      std::count_if(texels.begin(), texels.end(), [&](uint32_t t) { return is_inside[t] != 0; });
  const auto all = std::count_if(is_inside.begin(), is_inside.end(), [](uint8_t is) { return is != 0; });
  return static_cast<double>(read) > kMostRead * static_cast<double>(all);
}

/// Gives how many points stay beyond the limit.
template <typename Values>
size_t make_agree(Image& map, const std::vector<Seam>& seams, const std::vector<uint8_t>& is_inside,
                  const Values& values, const SeamPlaces& first) {
  std::vector<SeamPoint> more;
  for (int refinement = 0;; ++refinement) {
    std::optional<SeamPlaces> refined;
    if (!more.empty()) refined.emplace(seams, map.width_px, map.height_px, more);
    const SeamPlaces& places = refined ? *refined : first;
    std::vector<Vec3f> texels = read_texels(map, places.texels);
    const size_t beyond = Agreement<Values>(places, values, texels, hold_of(places.texels, is_inside)).run();
    write_texels(map, places.texels, texels);
    const std::vector<SeamPoint> points = points_beyond(map, seams, places.places, values);
    if (points.empty() || refinement == kRefinements) return beyond + points.size();
    more.insert(more.end(), points.begin(), points.end());
    std::sort(more.begin(), more.end());
  }
}

}  // namespace

LevelMending mend_level(Image& map, const std::vector<Seam>& seams, const std::vector<uint8_t>& is_inside,
                        MapValues values) {
  const bool is_normals = values == MapValues::kNormals;
  const SeamPlaces places(seams, map.width_px, map.height_px);
  const std::vector<Vec3f> before = read_texels(map, places.texels);
  SeamMender(seams, is_inside, map.width_px, map.height_px, 1)
      .mend(map, values, is_normals ? kSweptNormals : kSweptColours);
  LevelMending mending;
  mending.is_swept_only = reads_most(places.texels, is_inside);
  if (!mending.is_swept_only)
    mending.points_beyond = is_normals ? make_agree(map, seams, is_inside, NormalSeams(seams), places)
                                       : make_agree(map, seams, is_inside,
                                                    ColourSeams(values == MapValues::kLinearColour), places);
  const std::vector<Vec3f> after = read_texels(map, places.texels);
  for (size_t t = 0; t < after.size(); ++t)
    if (is_inside[places.texels[t]])
      for (int c = 0; c < 3; ++c)
        mending.most_changed = std::max(mending.most_changed, std::fabs(after[t][c] - before[t][c]));
  return mending;
}

}  // namespace ohb::bake
