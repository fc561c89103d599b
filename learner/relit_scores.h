// How near pictures of the estimated person under other light are to those of the true one: both as reliefs
// (relief.h), both by our path tracer.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "learner/data.h"
#include "learner/metrics.h"
#include "renderer/render.h"

namespace ohb::learner {

struct RelitOptions {
  std::vector<std::filesystem::path> environments;  // latitude-longitude; empty: our studio and sunset
  int views_a_person = 2;                           // evenly around the turn; 0: no relighting
  int spp = 64;                                     // paths a pixel
};

struct RelitRow {
  std::string name;
  std::map<std::string, std::vector<Psnr>> people;  // one an environment: mean over the person's pictures
  std::vector<Psnr> mean;                           // over people
};

struct RelitReport {
  std::vector<std::string> environments;  // the columns' names
  std::vector<RelitRow> rows;
  size_t pictures = 0;  // inputs that were relit
  int views_a_person = 0, spp = 0;
  double seconds_a_picture = 0;  // of all rows and environments
};

/// Radiance of maps under each light, (1, 3, N, N), linear, not multiplied by the mask. NaN in covered pixels
/// of which a map is not finite; black where nothing is covered.
std::vector<torch::Tensor> relit_radiance(const MaterialMaps& maps, const torch::Tensor& mask,
                                          const Camera& camera, float half_frame_cm,
                                          const renderer::LightSet& lights, int spp);

/// Pictures of maps under each light, (1, 3, N, N), sRGB-encoded and clipped to [0, 1], not multiplied by the
/// mask. NaN in covered pixels of which a map is not finite; black where nothing is covered.
std::vector<torch::Tensor> relit(const MaterialMaps& maps, const torch::Tensor& mask, const Camera& camera,
                                 float half_frame_cm, const renderer::LightSet& lights, int spp);

class RelitScores {
 public:
  /// Throws InputError as read_environment, and for two environments of one name.
  explicit RelitScores(const RelitOptions& options);

  /// Starts a picture: the truth that the next estimates are compared with.
  void begin(const Example& example, const Camera& camera);
  /// The estimate of a row for the picture that was begun. Rows appear in the order of their first estimate.
  void add(const std::string& row, const MaterialMaps& estimate);

  RelitReport report() const;

 private:
  struct Row {
    std::string name;
    std::map<std::string, MeanOf<std::vector<Psnr>>> people;
  };

  std::vector<torch::Tensor> timed_relit(const MaterialMaps& maps);

  RelitOptions options_;
  std::vector<std::string> names_;
  std::shared_ptr<const renderer::LightSet> lights_;
  std::string person_;
  torch::Tensor mask_;
  Camera camera_;
  float half_frame_cm_ = 0;
  std::vector<torch::Tensor> truth_;
  std::vector<Row> rows_;
  size_t pictures_ = 0;
  double seconds_ = 0;
};

/// The views that are relit, and the number of the light of the input in each: `count` of each person's
/// views, evenly spaced from the first, with the lights in turn. A function of the dataset alone.
std::map<std::filesystem::path, uint64_t> relit_views(const Dataset& dataset,
                                                      const std::vector<std::string>& people, int count);

std::string table_of(const RelitReport& report);
nlohmann::json json_of(const RelitReport& report);

}  // namespace ohb::learner
