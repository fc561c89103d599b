// Views of pictures (texture transforms, mirrored and clamped wrapping): moved into the UVs where they can
// be, else looked up when the picture is read.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "dataset/model/error.h"
#include "dataset/model/scan_readers.h"

namespace ohb {
namespace {

/// Rounding of the numbers in files: a view this close to plain is plain.
constexpr double kSame = 1e-6;
/// UVs that go no further than this beyond a tile do not use the next.
constexpr double kTileTolerance = 1e-3;
constexpr int kMostTiles = 64, kLongestPeriod = 8;
constexpr double kLargestViewNumber = 1e6;

bool is_whole(double x) {
  return std::abs(x - std::round(x)) < kSame;
}

bool is_identity(const PictureView& v) {
  return std::abs(v.uu - 1) < kSame && std::abs(v.vv - 1) < kSame && std::abs(v.uv) < kSame &&
         std::abs(v.vu) < kSame && std::abs(v.u0) < kSame && std::abs(v.v0) < kSame;
}

double determinant(const PictureView& v) {
  return v.uu * v.vv - v.uv * v.vu;
}

/// first, then `view`, whose wraps stay.
PictureView after(const PictureView& view, const PictureView& first) {
  PictureView both = view;
  both.uu = view.uu * first.uu + view.uv * first.vu;
  both.uv = view.uu * first.uv + view.uv * first.vv;
  both.u0 = view.uu * first.u0 + view.uv * first.v0 + view.u0;
  both.vu = view.vu * first.uu + view.vv * first.vu;
  both.vv = view.vu * first.uv + view.vv * first.vv;
  both.v0 = view.vu * first.u0 + view.vv * first.v0 + view.v0;
  return both;
}

PictureView inverse(const PictureView& v) {
  const double d = determinant(v);
  PictureView r;
  r.uu = v.vv / d;
  r.uv = -v.uv / d;
  r.vu = -v.vu / d;
  r.vv = v.uu / d;
  r.u0 = -(r.uu * v.u0 + r.uv * v.v0);
  r.v0 = -(r.vu * v.u0 + r.vv * v.v0);
  return r;
}

/// Whether a step of `by` along an axis of the picture shows the same again.
bool shows_same(Wrap wrap, double by) {
  if (wrap == Wrap::kClamp) return std::abs(by) < kSame;
  return is_whole(wrap == Wrap::kMirror ? by / 2 : by);
}

/// One axis of UV space: which tiles become [0,1].
struct Domain {
  int first = 0, count = 1;
};

class PictureSettler {
 public:
  explicit PictureSettler(Scan& scan)
      : scan_(scan), user_(scan.uvs.size(), kNobody), faces_(scan.materials.size()) {
    for (size_t f = 0; f < scan.face_count(); ++f) {
      faces_[scan.face_material[f]].push_back(static_cast<uint32_t>(f));
      for_corners(f, [&](Corner& corner) {
        uint32_t& user = user_[corner.uv];
        user = user == kNobody || user == scan.face_material[f] ? scan.face_material[f] : kSeveral;
      });
    }
  }

  void settle(uint16_t material) {
    ScanMaterial& own = scan_.materials[material];
    std::vector<ScanPicture*> pictures;
    for (ScanPicture* picture : {&own.diffuse, &own.alpha, &own.normal})
      if (!picture->empty()) pictures.push_back(picture);
    if (std::all_of(pictures.begin(), pictures.end(), [](auto* p) { return p->view.is_plain(); })) return;
    for (const ScanPicture* picture : pictures) check(own, picture->view);
    PictureView moved = pictures.front()->view;
    if (!(std::abs(determinant(moved)) > 1e-9)) moved = {};
    moved.wrap_u = moved.wrap_v = Wrap::kRepeat;
    if (!is_identity(moved)) {
      move_uvs(material, moved);
      see_through(pictures, inverse(moved));
      scan_.notes.push_back("material '" + own.name + "': its texture transform is applied to the UVs");
    }
    PictureView to_tiles;  // of UVs in [0,1]
    domain_along(material, pictures, 0, to_tiles.uu, to_tiles.u0);
    domain_along(material, pictures, 1, to_tiles.vv, to_tiles.v0);
    if (!is_identity(to_tiles)) {
      move_uvs(material, inverse(to_tiles));
      see_through(pictures, to_tiles);
      scan_.notes.push_back("material '" + own.name + "': mirrored or clamped beyond its picture's borders");
    }
    for (ScanPicture* picture : pictures)
      if (is_identity(picture->view)) picture->view = {};
  }

 private:
  static constexpr uint32_t kNobody = 0xffffffffu, kSeveral = 0xfffffffeu;

  template <typename Visit>
  void for_corners(size_t face, const Visit& visit) {
    for (size_t c = scan_.face_begin[face]; c < scan_.face_begin[face + 1]; ++c)
      if (scan_.corners[c].uv != Corner::kNoUv) visit(scan_.corners[c]);
  }
  template <typename Visit>
  void for_corners_of(uint16_t material, const Visit& visit) {
    for (uint32_t f : faces_[material]) for_corners(f, visit);
  }

  void check(const ScanMaterial& material, const PictureView& v) const {
    for (double number : {v.uu, v.uv, v.u0, v.vu, v.vv, v.v0})
      if (!(std::abs(number) <= kLargestViewNumber))
        throw InputError(scan_.file.string(), "material '" + material.name + "'",
                         "has a texture transform that is not finite or beyond 1000000", "correct it");
  }

  static void see_through(const std::vector<ScanPicture*>& pictures, const PictureView& first) {
    for (ScanPicture* picture : pictures) picture->view = after(picture->view, first);
  }

  /// UVs that other materials use too are copied.
  void move_uvs(uint16_t material, const PictureView& by) {
    std::unordered_map<uint32_t, uint32_t> moved;  // old and new number
    for_corners_of(material, [&](Corner& corner) {
      const auto [at, is_new] = moved.emplace(corner.uv, corner.uv);
      if (is_new) {
        const Vec2f from = scan_.uvs[corner.uv];
        const Vec2f to{static_cast<float>(by.uu * from.x + by.uv * from.y + by.u0),
                       static_cast<float>(by.vu * from.x + by.vv * from.y + by.v0)};
        if (user_[corner.uv] == kSeveral) {
          at->second = static_cast<uint32_t>(scan_.uvs.size());
          scan_.uvs.push_back(to);
          user_.push_back(material);
        } else {
          scan_.uvs[corner.uv] = to;
        }
      }
      corner.uv = at->second;
    });
  }

  /// Leaves scale and start alone where [0,1] shows all of the pictures along that axis.
  void domain_along(uint16_t material, const std::vector<ScanPicture*>& pictures, int axis, double& scale,
                    double& start) {
    double low = INFINITY, high = -INFINITY;
    for_corners_of(material, [&](const Corner& corner) {
      const double at = axis == 0 ? scan_.uvs[corner.uv].x : scan_.uvs[corner.uv].y;
      low = std::min(low, at);
      high = std::max(high, at);
    });
    if (!(low <= high)) return;
    const double first = std::floor(low + kTileTolerance);
    const double count = std::max(1.0, std::ceil(high - kTileTolerance) - first);
    if (first == 0 && count == 1) return;
    const auto repeats_after = [&](int tiles) {
      return std::all_of(pictures.begin(), pictures.end(), [&](const ScanPicture* picture) {
        const PictureView& v = picture->view;
        return shows_same(v.wrap_u, tiles * (axis == 0 ? v.uu : v.uv)) &&
               shows_same(v.wrap_v, tiles * (axis == 0 ? v.vu : v.vv));
      });
    };
    for (int period = 1; period <= kLongestPeriod && period <= count; ++period)
      if (repeats_after(period)) {
        scale = period;
        return;
      }
    if (count > kMostTiles)
      throw InputError(scan_.file.string(), "material '" + scan_.materials[material].name + "'",
                       "has UVs over " + std::to_string(static_cast<long long>(std::min(count, 1e15))) +
                           " tiles of a picture that does not repeat",
                       "move its UVs to at most " + std::to_string(kMostTiles) + " tiles");
    scale = count;
    start = first;
  }

  Scan& scan_;
  std::vector<uint32_t> user_;                // of each UV: its only material, kNobody or kSeveral
  std::vector<std::vector<uint32_t>> faces_;  // of each material
};

int wrapped(double index, int size, Wrap wrap) {
  if (wrap == Wrap::kClamp) return static_cast<int>(std::clamp(index, 0.0, size - 1.0));
  const double period = wrap == Wrap::kMirror ? 2.0 * size : size;
  const int rest = static_cast<int>(index - period * std::floor(index / period));
  return rest < size ? rest : std::max(0, 2 * size - 1 - rest);
}

/// A pixel and the share of the next along one axis; rounding makes no mixture.
struct Between {
  int here, next;
  double share;
  Between(double at, int size, Wrap wrap) {
    double whole = std::floor(at);
    share = at - whole;
    if (share > 1 - 1e-3) whole += 1;
    if (share < 1e-3 || share > 1 - 1e-3) share = 0;
    here = wrapped(whole, size, wrap);
    next = share > 0 ? wrapped(whole + 1, size, wrap) : here;
  }
};

struct ViewSize {
  int width_px, height_px, samples;  // samples: along each axis of a pixel, where the edge is limited
};

ViewSize size_of_view(const PictureView& v, int width_px, int height_px) {
  const double across = std::max(1.0, std::hypot(v.uu * width_px, v.vu * height_px));
  const double up = std::max(1.0, std::hypot(v.uv * width_px, v.vv * height_px));
  const double limit = std::min(1.0, kMaxViewedEdge_px / std::max(across, up));
  const auto edge = [&](double px) { return std::max(1, static_cast<int>(std::ceil(px * limit - 1e-3))); };
  return {edge(across), edge(up), std::min(16, static_cast<int>(std::ceil(1 / limit - 1e-3)))};
}

Image viewed(const Image& picture, const PictureView& v) {
  const ViewSize size = size_of_view(v, picture.width_px, picture.height_px);
  Image out(size.width_px, size.height_px, picture.channels);
  const float weight = 1.0f / static_cast<float>(size.samples * size.samples);
  tbb::parallel_for(0, out.height_px, [&](int y) {
    for (int x = 0; x < out.width_px; ++x)
      for (int s = 0; s < size.samples * size.samples; ++s) {
        const double u = (x + (s % size.samples + 0.5) / size.samples) / out.width_px;
        const double w = 1 - (y + (s / size.samples + 0.5) / size.samples) / out.height_px;
        const Between column((v.uu * u + v.uv * w + v.u0) * picture.width_px - 0.5, picture.width_px,
                             v.wrap_u);
        // Rows go down: the mirrored and clamped cases look the same from either end.
        const Between row((1 - (v.vu * u + v.vv * w + v.v0)) * picture.height_px - 0.5, picture.height_px,
                          v.wrap_v);
        const float* const corner[4] = {
            picture.pixel(column.here, row.here), picture.pixel(column.next, row.here),
            picture.pixel(column.here, row.next), picture.pixel(column.next, row.next)};
        for (int c = 0; c < picture.channels; ++c) {
          const double upper = corner[0][c] + column.share * (double(corner[1][c]) - corner[0][c]);
          const double lower = corner[2][c] + column.share * (double(corner[3][c]) - corner[2][c]);
          const auto value = static_cast<float>(upper + row.share * (lower - upper));
          out.pixel(x, y)[c] += size.samples == 1 ? value : weight * value;
        }
      }
  });
  return out;
}

}  // namespace

bool PictureView::is_plain() const {
  return is_identity(*this) && wrap_u == Wrap::kRepeat && wrap_v == Wrap::kRepeat;
}

void settle_pictures(Scan& scan) {
  const auto is_plain = [](const ScanMaterial& m) {
    return m.diffuse.view.is_plain() && m.alpha.view.is_plain() && m.normal.view.is_plain();
  };
  if (std::all_of(scan.materials.begin(), scan.materials.end(), is_plain)) return;
  PictureSettler settler(scan);
  for (size_t m = 0; m < scan.materials.size(); ++m) settler.settle(static_cast<uint16_t>(m));
}

Image read_image(const ScanPicture& picture, ImageFileInfo* info) {
  Image image = picture.embedded ? read_image_bytes(*picture.embedded, picture.file.string(), info)
                                 : read_image(picture.file, info);
  if (!picture.view.is_plain()) image = viewed(image, picture.view);
  if (info) {
    info->width_px = image.width_px;
    info->height_px = image.height_px;
  }
  return image;
}

ImageFileInfo probe_image(const ScanPicture& picture) {
  ImageFileInfo info = picture.embedded ? probe_image_bytes(*picture.embedded, picture.file.string())
                                        : probe_image(picture.file);
  if (picture.view.is_plain()) return info;
  const ViewSize size = size_of_view(picture.view, info.width_px, info.height_px);
  info.width_px = size.width_px;
  info.height_px = size.height_px;
  return info;
}

}  // namespace ohb
