#include "dataset/studies/bake_stress.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "bake/seams.h"
#include "dataset/model/error.h"
#include "dataset/model/model_files.h"
#include "dataset/model/progress.h"
#include "dataset/studies/bake_stress_scenes.h"

namespace ohb::studies {
namespace fs = std::filesystem;
namespace {

constexpr int kPointsAlong = 12;  // of a triangle: a lattice of 78 points inside it
constexpr double kWrongNormal_deg = 3, kWrongColour = 0.05, kPercentile = 0.95;
constexpr MaterialTable kTable = {
    {{0.184f, 0.4f, 0.08f}, {0.239f, 0.5f, 0}, {0.263f, 0.85f, 0}, {0.224f, 0.25f, 0}}};

/// Bilinear, as renderers look maps up (docs/conventions.md).
std::array<double, 3> looked_up(const Image& image, Vec2f uv) {
  std::array<double, 3> value{};
  const double x = (uv.x - std::floor(uv.x)) * image.width_px - 0.5;
  const double y = (1 - (uv.y - std::floor(uv.y))) * image.height_px - 0.5;
  const double x0 = std::floor(x), y0 = std::floor(y);
  const auto wrap = [](double i, int n) { return (static_cast<int>(i) % n + n) % n; };
  for (int k = 0; k < 4; ++k) {
    const int dx = k & 1, dy = k >> 1;
    const double weight = (dx ? x - x0 : 1 - (x - x0)) * (dy ? y - y0 : 1 - (y - y0));
    const float* const texel = image.pixel(wrap(x0 + dx, image.width_px), wrap(y0 + dy, image.height_px));
    for (int c = 0; c < image.channels; ++c) value[static_cast<size_t>(c)] += weight * texel[c];
  }
  return value;
}

/// A point of triangle t by its barycentric weights.
struct Place {
  size_t triangle;
  float weights[3];
};

template <class Value>
Value blend(const Place& place, Value a, Value b, Value c) {
  return place.weights[0] * a + place.weights[1] * b + place.weights[2] * c;
}

/// The normal that a renderer shades with there, unit, in the model's frame.
Vec3f shading_normal(const Model& model, const bake::MeshFrames& frames, const Place& place, Vec2f uv) {
  const ModelTriangle& t = model.triangles[place.triangle];
  const CornerTangent* const corner = &frames.tangents[3 * place.triangle];
  const Vec3f normal = blend(place, frames.normals[t.position[0]], frames.normals[t.position[1]],
                             frames.normals[t.position[2]]);
  if (model.sets[t.set].normal.values.empty()) return normalised(normal);
  const Vec3f tangent = blend(place, corner[0].tangent, corner[1].tangent, corner[2].tangent);
  const Vec3f bitangent = corner[0].sign * cross(normal, tangent);
  const std::array<double, 3> m = looked_up(model.sets[t.set].normal, uv);
  return normalised(static_cast<float>(m[0]) * tangent + static_cast<float>(m[1]) * bitangent +
                    static_cast<float>(m[2]) * normal);
}

double percentile(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(kPercentile * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Errors at points spread evenly over the sheet, each standing for the same area.
struct Errors {
  std::vector<double> normal_deg, colour, alpha, depth_cm;
  size_t wrong = 0;
};

void add_errors(const BakeStressScene& scene, const Model& model, const bake::MeshFrames& frames,
                const Place& place, Errors& errors) {
  const ModelTriangle& t = model.triangles[place.triangle];
  const TextureSet& set = model.sets[t.set];
  const Vec2f uv = blend(place, model.uvs[t.uv[0]], model.uvs[t.uv[1]], model.uvs[t.uv[2]]);
  const Vec3f position = blend(place, model.positions_cm[t.position[0]], model.positions_cm[t.position[1]],
                               model.positions_cm[t.position[2]]);
  const Vec3f at = position - model.source_shift_cm - scene.place;
  const SheetTruth truth = sheet_truth(at.x, at.y);
  const bool has_source = scene.options.source.scan != nullptr;
  if (has_source) {
    const Vec3f found = shading_normal(model, frames, place, uv);
    const double sine = length(cross(found, truth.normal)), cosine = dot(found, truth.normal);
    errors.normal_deg.push_back(std::atan2(sine, cosine) * 57.29577951308232);
    const double z = looked_up(set.displacement, uv)[0] - model.source_shift_cm.z;
    errors.depth_cm.push_back(std::fabs(z - truth.z));
  }
  const std::array<double, 3> albedo = looked_up(set.albedo, uv);
  double colour = 0;
  for (int c = 0; c < 3; ++c)
    colour = std::max(colour, std::fabs(albedo[static_cast<size_t>(c)] - truth.albedo[c]));
  errors.colour.push_back(colour);
  if (scene.has_alpha && !set.alpha.values.empty())
    errors.alpha.push_back(std::fabs(looked_up(set.alpha, uv)[0] - truth.alpha));
  errors.wrong += (has_source && errors.normal_deg.back() > kWrongNormal_deg) || colour > kWrongColour;
}

void measure(const BakeStressScene& scene, const Model& model, BakeStressResult& result) {
  for (const TextureSet& set : model.sets)
    for (const MapKind& kind : kMapKinds)
      for (const float value : (set.*kind.image).values) result.nonfinite += !std::isfinite(value);
  const bake::MeshFrames frames = bake::frames_of(model);
  Errors errors;
  for (size_t t = 0; t < model.triangles.size(); ++t) {
    if (model.triangles[t].source_face >= scene.measured_faces) continue;
    for (int i = 0; i < kPointsAlong; ++i)
      for (int j = 0; i + j < kPointsAlong; ++j) {
        const float u = (static_cast<float>(i) + 1.0f / 3) / kPointsAlong;
        const float v = (static_cast<float>(j) + 1.0f / 3) / kPointsAlong;
        add_errors(scene, model, frames, {t, {1 - u - v, u, v}}, errors);
      }
  }
  result.wrong = static_cast<double>(errors.wrong) / static_cast<double>(errors.colour.size());
  result.normal_deg = percentile(errors.normal_deg);
  result.colour = percentile(errors.colour);
  result.alpha = percentile(errors.alpha);
  result.depth_cm = percentile(errors.depth_cm);
}

void judge(BakeStressResult& result) {
  const BakeStressAcceptance& accept = result.point.accept;
  const auto fail = [&](const std::string& words) { result.failures.push_back(words); };
  if (!accept.refused.empty()) {
    if (result.refusal.empty())
      fail("was baked, and should be refused with '" + accept.refused + "'");
    else if (result.refusal.find(accept.refused) == std::string::npos)
      fail("was refused without '" + accept.refused + "': " + result.refusal);
    return;
  }
  if (!result.refusal.empty()) return fail("was refused: " + result.refusal);
  if (result.nonfinite > 0) fail(fmt::format("{} texels are not finite", result.nonfinite));
  const auto limit = [&](double value, double most, const char* what) {
    if (most >= 0 && !(value <= most)) fail(fmt::format("{} {:.4g} (at most {:g})", what, value, most));
  };
  limit(result.normal_deg, accept.normal_deg, "normals off by degrees:");
  limit(result.colour, accept.colour, "albedo off by");
  limit(result.alpha, accept.alpha, "cut-out off by");
  limit(result.depth_cm, accept.depth_cm, "displacement off by cm:");
  limit(result.wrong, accept.wrong, "share of the surface that is wrong:");
  if (accept.warned.empty()) return;
  for (const std::string& warning : result.warnings)
    if (warning.find(accept.warned) != std::string::npos) return;
  fail("no warning says '" + accept.warned + "'");
}

}  // namespace

std::vector<BakeStressCaseResult> run_bake_stress(const std::vector<BakeStressCase>& catalogue,
                                                  const std::string& only, const fs::path& scratch) {
  size_t count = 0;
  for (const BakeStressCase& stress : catalogue) count += stress.points.size();
  Progress progress("bake stress", count);
  std::vector<BakeStressCaseResult> all;
  for (const BakeStressCase& stress : catalogue) {
    if (!only.empty() && stress.name != only) continue;
    all.push_back({stress, {}});
    for (const BakeStressPoint& point : stress.points) {
      BakeStressResult result;
      result.point = point;
      BakeStressScene scene;
      make_bake_stress_scene(stress.scene, point.at, scratch, scene);
      try {
        bake::BakeReport report;
        const Model model = bake::bake_model(scene.low, scene.regions, kTable, scene.options, &report);
        result.warnings = bake::warnings_of(report);
        measure(scene, model, result);
      } catch (const InputError& error) {
        result.refusal = error.what();
      }
      judge(result);
      all.back().results.push_back(std::move(result));
      progress.add();
    }
  }
  if (all.empty())
    throw InputError("", "--case " + only, "the catalogue has no case of that name",
                     "use a name that it has");
  return all;
}

}  // namespace ohb::studies
