#include "dataset/commands/label_preview.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dataset/commands/label_maps.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/image.h"

namespace ohb::commands {
namespace {

constexpr int kHeight_px = 720, kMostWidth_px = 1440, kMargin_px = 16, kHatch_px = 6, kLine_px = 22;

struct PictureFrame {
  Vec3f low{1e30f, 1e30f, 1e30f}, high{-1e30f, -1e30f, -1e30f};
  float scale = 1;  // px a unit
  int width_px = 1, height_px = 1;
};

PictureFrame frame_of(const Scan& scan) {
  PictureFrame frame;
  for (const Vec3f& p : scan.positions)
    for (int i = 0; i < 3; ++i) {
      if (!std::isfinite(p[i])) continue;
      frame.low[i] = std::min(frame.low[i], p[i]);
      frame.high[i] = std::max(frame.high[i], p[i]);
    }
  const float height = std::max(frame.high.y - frame.low.y, 1e-12f),
              width = std::max(frame.high.x - frame.low.x, 1e-12f);
  frame.scale = std::min((kHeight_px - 2 * kMargin_px) / height, (kMostWidth_px - 2 * kMargin_px) / width);
  frame.width_px = static_cast<int>(std::ceil(width * frame.scale)) + 2 * kMargin_px;
  frame.height_px = static_cast<int>(std::ceil(height * frame.scale)) + 2 * kMargin_px;
  return frame;
}

/// One view: the nearest face of each pixel wins.
class View {
 public:
  View(const PictureFrame& frame, float side)
      : frame_(frame), side_(side), image_(frame.width_px, frame.height_px, 3) {
    std::fill(image_.values.begin(), image_.values.end(), 1.0f);
    depth_.assign(image_.values.size() / 3, -std::numeric_limits<float>::max());
  }

  void draw(const std::array<Vec3f, 3>& corner, Vec3f colour, bool is_hatched) {
    std::array<Vec3f, 3> p;
    for (int i = 0; i < 3; ++i) p[i] = project(corner[i]);
    const float area = (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[2].x - p[0].x) * (p[1].y - p[0].y);
    const Vec3f normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
    const float size = length(normal);
    if (!(std::abs(area) > 1e-6f) || !(size > 0)) return;
    const float shade = 0.45f + 0.55f * std::abs(normal.z) / size;
    const auto [low_x, high_x] = range(p[0].x, p[1].x, p[2].x, frame_.width_px);
    const auto [low_y, high_y] = range(p[0].y, p[1].y, p[2].y, frame_.height_px);
    for (int y = low_y; y <= high_y; ++y)
      for (int x = low_x; x <= high_x; ++x) {
        const float u = static_cast<float>(x) + 0.5f, v = static_cast<float>(y) + 0.5f;
        const float b = ((u - p[0].x) * (p[2].y - p[0].y) - (p[2].x - p[0].x) * (v - p[0].y)) / area;
        const float c = ((p[1].x - p[0].x) * (v - p[0].y) - (u - p[0].x) * (p[1].y - p[0].y)) / area;
        if (b < 0 || c < 0 || b + c > 1) continue;
        const float depth = p[0].z + b * (p[1].z - p[0].z) + c * (p[2].z - p[0].z);
        float& nearest = depth_[static_cast<size_t>(y) * image_.width_px + x];
        if (!(depth > nearest)) continue;
        nearest = depth;
        const bool is_line = is_hatched && (x + y) / (kHatch_px / 2) % 2 == 0;
        const Vec3f shown = is_line ? 0.5f * shade * colour + Vec3f{0.5f, 0.5f, 0.5f} : shade * colour;
        std::copy_n(&shown.x, 3, image_.pixel(x, y));
      }
  }
  const Image& image() const { return image_; }

 private:
  Vec3f project(Vec3f p) const {
    const float x = side_ > 0 ? p.x - frame_.low.x : frame_.high.x - p.x;
    return {kMargin_px + x * frame_.scale, kMargin_px + (frame_.high.y - p.y) * frame_.scale, side_ * p.z};
  }
  static std::pair<int, int> range(float a, float b, float c, int size) {
    return {std::max(0, static_cast<int>(std::min({a, b, c}))),
            std::min(size - 1, static_cast<int>(std::max({a, b, c})))};
  }

  const PictureFrame& frame_;
  float side_;  // 1: from the front, -1: from the back
  Image image_;
  std::vector<float> depth_;
};

/// What the colours mean, a line each.
std::vector<std::string> legend_of(const PictureFrame& frame, const LabelReport& report) {
  std::vector<std::string> lines;
  const auto swatch = [&](const std::string& colour, const std::string& text) {
    const int y = frame.height_px + kLine_px * static_cast<int>(lines.size() + 1);
    lines.push_back(
        fmt::format("<rect x=\"16\" y=\"{}\" width=\"16\" height=\"14\" fill=\"{}\" stroke=\"#888\"/>"
                    "<text x=\"40\" y=\"{}\">{}</text>\n",
                    y - 12, colour, y, text));
  };
  for (uint8_t c = 0; c < kClassCount; ++c) {
    const Vec3f colour = class_colour(c);
    swatch(fmt::format("#{:02x}{:02x}{:02x}", std::lround(255 * colour.x), std::lround(255 * colour.y),
                       std::lround(255 * colour.z)),
           fmt::format("{}: {:.1f} % of the area", kClassNames[c],
                       report.total_area > 0 ? 100 * report.classes[c].area / report.total_area : 0));
  }
  if (report.inferred)
    for (const QuestionReport& question : report.inferred->questions)
      swatch("url(#asked)",
             fmt::format("{}, {:.0f} cm2: {} or {}? (--answer {}={})", question.name, question.area_cm2,
                         kClassNames[question.now], kClassNames[question.rival], question.name,
                         kClassNames[question.rival]));
  return lines;
}

std::string svg_of(const PictureFrame& frame, const LabelReport& report) {
  const std::vector<std::string> lines = legend_of(frame, report);
  const int width = 2 * frame.width_px,
            height = frame.height_px + kLine_px * static_cast<int>(lines.size() + 1);
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" width=\"{0}\" "
      "height=\"{1}\" viewBox=\"0 0 {0} {1}\" font-family=\"sans-serif\" font-size=\"14\">\n"
      "<defs><pattern id=\"asked\" width=\"6\" height=\"6\" patternUnits=\"userSpaceOnUse\" "
      "patternTransform=\"rotate(45)\"><rect width=\"3\" height=\"6\" fill=\"#888\"/></pattern></defs>\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      std::max(width, 640), height);
  int x = 0;
  for (const char* side : {"front", "back"}) {
    svg += fmt::format(
        "<image x=\"{0}\" width=\"{1}\" height=\"{2}\" href=\"preview_{3}.png\" "
        "xlink:href=\"preview_{3}.png\"/><text x=\"{4}\" y=\"14\">{3}</text>\n",
        x, frame.width_px, frame.height_px, side, x + 4);
    x += frame.width_px;
  }
  for (const std::string& line : lines) svg += line;
  return svg + "</svg>\n";
}

}  // namespace

void write_previews(const std::filesystem::path& folder, const Scan& scan,
                    const std::vector<uint8_t>& face_class, const std::vector<uint32_t>& question_of_face,
                    const LabelReport& report) {
  const PictureFrame frame = frame_of(scan);
  const size_t asked = report.inferred ? report.inferred->questions.size() : 0;
  const std::vector<ScanTriangle> triangles = triangulate(scan);
  for (const auto& [side, name] :
       {std::pair(1.0f, "preview_front.png"), std::pair(-1.0f, "preview_back.png")}) {
    View view(frame, side);
    for (const ScanTriangle& triangle : triangles) {
      std::array<Vec3f, 3> corner;
      for (int i = 0; i < 3; ++i) corner[i] = scan.positions[scan.corners[triangle.corner[i]].position];
      const bool is_asked =
          triangle.face < question_of_face.size() && question_of_face[triangle.face] < asked;
      view.draw(corner, class_colour(face_class[triangle.face]), is_asked);
    }
    write_png(folder / name, view.image());
  }
  write_file_atomically(folder / "preview.svg", svg_of(frame, report));
}

}  // namespace ohb::commands
