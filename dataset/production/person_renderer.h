// One person's sets of images. The model is read and its trees are built once, environments are kept.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "dataset/production/environment_cache.h"
#include "dataset/production/file_hashes.h"
#include "dataset/production/plan.h"
#include "dataset/production/stages.h"

namespace ohb::production {

/// What the time of a person's sets went to.
struct RenderTimes {
  double loading_s = 0;  // the model and its trees
  double environments_s = 0, maps_s = 0, lights_s = 0;
};

class PersonRenderer {
 public:
  /// Reads nothing yet: a person whose sets are all done costs nothing.
  PersonRenderer(const Plan& plan, const PlanPerson& person, BakedPerson baked);

  /// The hash of everything that a set's file is made of: model, settings, lights' content, seed, version.
  std::string unit_hash(const PlannedSet& set, FileHashes& hashes) const;

  /// Every map and lit image of the set. `alive` is called now and then, from any thread, and may throw to
  /// stop. Throws as read_model and read_environment.
  Sample render(const PlannedSet& set, FileHashes& hashes, const std::function<void()>& alive);
  /// The same with other numbers of paths and pixels, for checks.
  Sample render(const PlannedSet& set, FileHashes& hashes, int spp, const std::function<void()>& alive);

  /// Header attributes that all sets share (sample_listing.h). Reads the model's mesh.
  const ExrAttributes& settings();

  const RenderTimes& times() const { return times_; }
  const EnvironmentCache& environments() const { return environments_; }

 private:
  void load();
  renderer::RenderSettings settings_of(const PlannedSet& set) const;
  ExrAttributes attributes_of(const PlannedSet& set, FileHashes& hashes);

  const Plan& plan_;
  const PlanPerson& person_;
  const ViewSet& views_;
  BakedPerson baked_;
  EnvironmentCache environments_;
  std::shared_ptr<const renderer::Scene> scene_;
  Camera camera_;
  ExrAttributes shared_;
  RenderTimes times_;
};

}  // namespace ohb::production
