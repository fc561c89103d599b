#include "learner/relit_scores.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "dataset/model/data_files.h"
#include "dataset/model/error.h"
#include "learner/relief.h"
#include "learner/task.h"

namespace ohb::learner {
namespace fs = std::filesystem;
namespace {

using torch::Tensor;

// Of every picture: truth and estimates share their noise where they are alike.
constexpr uint64_t kSeed = 1;

std::vector<Environment> environments_of(const RelitOptions& options) {
  std::vector<fs::path> files = options.environments;
  if (files.empty())
    for (const char* name : {"studio", "sunset"})
      files.push_back(program_file(fs::path("assets/environments") / (std::string(name) + ".exr")));
  std::vector<Environment> environments;
  for (const fs::path& file : files) {
    environments.push_back(read_environment(file));
    for (size_t i = 0; i + 1 < environments.size(); ++i)
      if (environments[i].name == environments.back().name)
        throw InputError(file.string(), "",
                         "another environment is named '" + environments.back().name + "' too",
                         "rename one of the files: columns are named by them");
  }
  return environments;
}

/// Interleaved pixels to (1, 3, H, W).
Tensor tensor_of(const Image& image) {
  Tensor pixels = torch::empty({image.height_px, image.width_px, image.channels}, torch::kFloat);
  std::copy(image.values.begin(), image.values.end(), pixels.data_ptr<float>());
  return pixels.permute({2, 0, 1}).unsqueeze(0).contiguous();
}

/// Bounding box of the covered pixels of (1, 1, N, N); the empty box, which stands for all, if there are
/// none.
renderer::PixelBox box_of(const Tensor& mask) {
  const Tensor covered = (mask[0][0] > 0).nonzero();  // rows of (y, x)
  if (covered.size(0) == 0) return {};
  const Tensor low = std::get<0>(covered.min(0)), high = std::get<0>(covered.max(0));
  return {low[1].item<int>(), low[0].item<int>(), high[1].item<int>() + 1, high[0].item<int>() + 1};
}

}  // namespace

std::vector<Tensor> relit_radiance(const MaterialMaps& maps, const Tensor& mask, const Camera& camera,
                                   float half_frame_cm, const renderer::LightSet& lights, int spp) {
  renderer::RenderSettings settings;
  settings.size_px = static_cast<int>(mask.size(3));
  settings.spp = spp;
  settings.seed = kSeed;
  settings.subsurface = false;  // an open sheet has no inside: walks would leave through its missing back
  settings.crop = box_of(mask);
  const auto scene = renderer::build_scene(relief_of(maps, mask, camera, half_frame_cm));
  const auto images = renderer::render_lights({*scene, lights, camera, 0}, settings);
  const Tensor unknown = (mask > 0) & ~known_pixels(maps, mask);
  std::vector<Tensor> pictures;
  for (const SampleLight& image : images)
    pictures.push_back(tensor_of(image.radiance).masked_fill(unknown, std::nan("")));
  return pictures;
}

std::vector<Tensor> relit(const MaterialMaps& maps, const Tensor& mask, const Camera& camera,
                          float half_frame_cm, const renderer::LightSet& lights, int spp) {
  std::vector<Tensor> pictures = relit_radiance(maps, mask, camera, half_frame_cm, lights, spp);
  for (Tensor& picture : pictures) picture = srgb_of(picture);
  return pictures;
}

RelitScores::RelitScores(const RelitOptions& options) : options_(options) {
  const std::vector<Environment> environments = environments_of(options);
  for (const Environment& environment : environments) names_.push_back(environment.name);
  lights_ = renderer::prepare_lights(environments, {});
}

std::vector<Tensor> RelitScores::timed_relit(const MaterialMaps& maps) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<Tensor> pictures = relit(maps, mask_, camera_, half_frame_cm_, *lights_, options_.spp);
  seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return pictures;
}

void RelitScores::begin(const Example& example, const Camera& camera) {
  person_ = example.person;
  mask_ = example.mask;
  camera_ = camera;
  half_frame_cm_ = example.half_frame_cm;
  truth_ = timed_relit(example.truth);
  ++pictures_;
}

void RelitScores::add(const std::string& name, const MaterialMaps& estimate) {
  const std::vector<Tensor> pictures = timed_relit(estimate);
  std::vector<Psnr> scores;
  for (size_t i = 0; i < pictures.size(); ++i) scores.push_back(psnr(pictures[i], truth_[i], mask_));
  auto row = std::find_if(rows_.begin(), rows_.end(), [&](const Row& r) { return r.name == name; });
  if (row == rows_.end()) row = rows_.insert(rows_.end(), {name, {}});
  row->people[person_].add(scores);
}

RelitReport RelitScores::report() const {
  RelitReport report;
  report.environments = names_;
  report.pictures = pictures_;
  report.views_a_person = options_.views_a_person;
  report.spp = options_.spp;
  report.seconds_a_picture = seconds_ / static_cast<double>(std::max<size_t>(1, pictures_));
  for (const Row& row : rows_) {
    RelitRow r{row.name, {}, {}};
    MeanOf<std::vector<Psnr>> over_people;
    for (const auto& [person, scores] : row.people) {
      r.people[person] = scores.mean();
      over_people.add(r.people[person]);
    }
    r.mean = over_people.mean();
    report.rows.push_back(r);
  }
  return report;
}

std::map<fs::path, uint64_t> relit_views(const Dataset& dataset, const std::vector<std::string>& people,
                                         int count) {
  std::map<fs::path, uint64_t> chosen;
  for (const std::string& person : people) {
    const std::vector<fs::path> views = views_of(dataset, {person});
    const size_t wanted = std::min(views.size(), static_cast<size_t>(std::max(0, count)));
    for (size_t i = 0; i < wanted; ++i) chosen[views[i * views.size() / wanted]] = i;
  }
  return chosen;
}

std::string table_of(const RelitReport& report) {
  std::string text = fmt::format(
      "PSNR of the person relit by our path tracer, dB: {} pictures, the foreground | the whole frame\n\n"
      "| row             |",
      report.pictures);
  for (const char* part : {"", " frame"})
    for (const std::string& name : report.environments) text += fmt::format(" {:>6} |", name + part);
  text += "\n|-----------------|";
  for (const char* part : {"", " frame"})
    for (const std::string& name : report.environments)
      text += std::string(std::max<size_t>(6, name.size() + std::string(part).size()) + 1, '-') + ":|";
  text += "\n";
  for (const RelitRow& row : report.rows) {
    text += fmt::format("| {:<15} |", row.name);
    for (const auto& [part, value] : {std::pair{"", &Psnr::masked}, {" frame", &Psnr::full}})
      for (size_t i = 0; i < row.mean.size(); ++i)
        text += table_cell(row.mean[i].*value, (report.environments[i] + part).size());
    text += "\n";
  }
  return text + "\n";
}

nlohmann::json json_of(const RelitReport& report) {
  const auto scores_json = [&](const std::vector<Psnr>& scores) {
    nlohmann::json json;
    for (size_t i = 0; i < scores.size(); ++i)
      json[report.environments[i]] = {{"masked", json_number(scores[i].masked)},
                                      {"full", json_number(scores[i].full)}};
    return json;
  };
  nlohmann::json json = {{"environments", report.environments},
                         {"pictures", report.pictures},
                         {"views_a_person", report.views_a_person},
                         {"spp", report.spp},
                         {"seconds_a_picture", report.seconds_a_picture}};
  for (const RelitRow& row : report.rows) {
    nlohmann::json r = {{"name", row.name}, {"mean", scores_json(row.mean)}};
    for (const auto& [person, scores] : row.people) r["people"][person] = scores_json(scores);
    json["rows"].push_back(r);
  }
  return json;
}

}  // namespace ohb::learner
