#include "learner/estimate.h"

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/camera.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"
#include "dataset/model/scattering.h"

namespace ohb::learner {
namespace fs = std::filesystem;
namespace {

using torch::Tensor;

constexpr int kPngBits = 16, kMostNatural_px = 1024;
constexpr double kHalfWidth = 0.5 * kSensorMm / kLensMm;  // tangent of half the field of view

/// (1, C, H, W) to interleaved pixels.
Image image_of(const Tensor& map) {
  const Tensor pixels = map[0].permute({1, 2, 0}).contiguous().to(torch::kFloat);
  Image image(static_cast<int>(pixels.size(1)), static_cast<int>(pixels.size(0)),
              static_cast<int>(pixels.size(2)));
  std::copy_n(pixels.data_ptr<float>(), image.values.size(), image.values.begin());
  return image;
}

/// The maps with the background at fixed values, and no scattering where there is as good as none.
MaterialMaps on_black(const MaterialMaps& maps, const Tensor& mask) {
  const Tensor inside = mask > 0;
  MaterialMaps black;
  for (const LearnedMap& map : kMaps) {
    Tensor background = torch::zeros_like(maps.*map.tensor);
    if (map.tensor == &MaterialMaps::normal) background.select(1, 2).fill_(1);
    black.*map.tensor = torch::where(inside, maps.*map.tensor, background);
  }
  black.sss = torch::where(black.sss < kLeastScattering, torch::zeros_like(black.sss), black.sss);
  return black;
}

/// The frame in cm, from the height that the mask covers.
struct PictureFrame {
  double half_cm, center_y_cm;
};
PictureFrame frame_of(const Image& mask, const Crop& crop, double height_cm) {
  int top = mask.height_px, bottom = -1;
  for (int y = 0; y < mask.height_px; ++y)
    for (int x = 0; x < mask.width_px; ++x)
      if (*mask.pixel(x, y) > 0.5f) top = std::min(top, y), bottom = y;
  const double cm_per_px = height_cm / (bottom - top + 1);
  return {0.5 * crop.side_px * cm_per_px, 0.5 * height_cm};
}

void write_pngs(const fs::path& folder, const MaterialMaps& maps, const Foreground& foreground) {
  const auto write = [&](const char* name, const Tensor& map) {
    write_png(folder / (std::string(name) + ".png"), image_of(map), kPngBits);
  };
  write("mask", foreground.mask);
  for (const LearnedMap& map : kMaps) write(map.name, stored_values(map, maps));
  write("input", (foreground.input.slice(1, 0, 3) + 1) / 2);
}

void write_maps_exr(const fs::path& file, const MaterialMaps& maps, const Tensor& mask,
                    const PictureFrame& frame) {
  std::vector<ExrPart> parts = {{"mask", {"A"}, ExrPart::Type::kFloat, image_of(mask)}};
  for (const LearnedMap& map : kMaps) {
    const bool is_length = map.tensor == &MaterialMaps::displacement;
    std::vector<std::string> channels;
    for (const char channel : map.channels) channels.emplace_back(1, channel);
    parts.push_back({map.name, channels, ExrPart::Type::kFloat,
                     image_of(is_length ? maps.*map.tensor * frame.half_cm : maps.*map.tensor)});
  }
  write_exr(file, parts, {{"ohb:displacementRange_cm", std::to_string(frame.half_cm)}});
}

nlohmann::json maps_json(const EstimateOptions& options, const EstimateReport& report,
                         const PictureFrame& frame) {
  nlohmann::json maps = {{"mask", {{"file", "mask.png"}, {"encoding", "coverage"}}}};
  nlohmann::json conventions = {
      {"axes", "right-handed, +X right, +Y up, +Z to the viewer, soles at y = 0"},
      {"mask", "share of the pixel that is covered; the other maps are averages over the covered part"},
      {"exr",
       "maps.exr holds the same maps as float parts: normal signed, diffuse linear, displacement in cm"}};
  for (const LearnedMap& map : kMaps) {
    maps[map.name] = {{"file", std::string(map.name) + ".png"}, {"encoding", map.encoding}};
    conventions[map.name] = map.convention;
  }
  maps["displacement"]["r_cm"] = frame.half_cm;
  return {{"format", "humanmaterial.maps"},
          {"version", 1},
          {"unit", "cm"},
          {"size_px", {report.size_px, report.size_px}},
          {"camera",
           {{"type", "perspective"},
            {"distance_cm", frame.half_cm / kHalfWidth},
            {"half_width", kHalfWidth},
            {"center_y_cm", frame.center_y_cm}}},
          {"maps", maps},
          {"conventions", conventions},
          {"source",
           {{"program", "humanmaterial " OHB_VERSION},
            {"photo", options.photo.filename().string()},
            {"photo_crop_px",
             {{"left", report.crop.left_px}, {"top", report.crop.top_px}, {"side", report.crop.side_px}}},
            {"assumed_person_height_cm", options.person_height_cm},
            {"finetuned", report.finetuned}}}};
}

/// Weights may be finite, and what they make of a photo not.
void check_finite(const MaterialMaps& maps, const fs::path& photo) {
  for (const LearnedMap& map : kMaps)
    if (!torch::isfinite(maps.*map.tensor).all().item<bool>())
      throw InputError(photo.string(), std::string("map '") + map.name + "'",
                       "comes out as NaN or infinite: the weights are of no use", "give other --weights");
}

/// The mask or alpha that was given, or else what matting finds.
Image mask_for(const Photo& photo, const EstimateOptions& options, int& people) {
  if (options.matting.person > 1 && (options.mask || has_cutout(photo)))
    throw InputError(options.photo.string(), "--person " + std::to_string(options.matting.person),
                     std::string("is of people that are looked for, and ") +
                         (options.mask ? "--mask" : "its alpha") + " says who it is",
                     "leave out one of the two");
  if (options.mask || has_cutout(photo)) return mask_of(photo, options.photo, options.mask);
  Matte matte = find_person(photo, options.photo, options.matting);
  people = matte.people;
  return std::move(matte.mask);
}

}  // namespace

int natural_size(const Crop& crop, int network_px) {
  const int own_px =
      static_cast<int>(std::lround(crop.side_px / kResolutionStep)) * static_cast<int>(kResolutionStep);
  return std::max(network_px, std::min(own_px, kMostNatural_px));
}

EstimateReport estimate(const EstimateOptions& options) {
  if (!(options.person_height_cm > 0 && options.person_height_cm < 1e4))
    throw InputError("", "--height", "is not a length above 0 cm", "give the person's height");
  Photo photo = read_photo(options.photo);
  int people = 0;
  const Image mask = mask_for(photo, options, people);
  keep_foreground_colours(photo, mask);
  const Estimator estimator(options.weights);
  EstimateReport report;
  report.crop = crop_around(mask);
  report.size_px =
      options.size_px > 0 ? options.size_px : natural_size(report.crop, estimator.header().at("size_px"));
  if (report.size_px % kResolutionStep != 0 || report.size_px > 4096)
    throw InputError("", "--size " + std::to_string(report.size_px), "is no multiple of 16 up to 4096",
                     "give another");
  report.people = people;
  report.finetuned = estimator.has_finetune();
  const Foreground foreground = foreground_of(photo, mask, report.crop, report.size_px);
  std::vector<fs::path> inputs = options.weights;
  inputs.push_back(options.photo);
  if (options.mask) inputs.push_back(*options.mask);
  if (options.matting.network) inputs.push_back(*options.matting.network);
  AtomicFolder folder(options.output, "maps", inputs);
  const auto start = std::chrono::steady_clock::now();
  const MaterialMaps maps = on_black(estimator.estimate(foreground.input), foreground.mask);
  check_finite(maps, options.photo);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const PictureFrame frame = frame_of(mask, report.crop, options.person_height_cm);
  write_pngs(folder.path(), maps, foreground);
  write_maps_exr(folder.path() / "maps.exr", maps, foreground.mask, frame);
  write_file_atomically(folder.path() / "maps.json", json_text(maps_json(options, report, frame), 2) + "\n");
  folder.commit();
  return report;
}

}  // namespace ohb::learner
