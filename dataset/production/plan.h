// What a production makes: plan.xml, read strictly (docs/plan.md). People with their split, the classes'
// materials, and for each split which views are rendered under which lights.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dataset/model/material_table.h"
#include "renderer/render_to_error.h"

namespace ohb::production {

/// One person: a scan, and where its classes come from.
struct PlanPerson {
  std::string id;  // names a folder: letters, digits, '_', '-', '.', at most 64
  std::string split;
  std::filesystem::path scan;
  std::filesystem::path labels;   // finished classes of the faces; or
  std::filesystem::path regions;  // a folder that `label` wrote; or
  bool is_automatic = false;      // labels="auto": start labels
  std::string unit;               // as --unit of bake; empty: guessed
  /// sex, age, group, licence, as far as they are known; sorted by name.
  std::map<std::string, std::string> attributes;
};

struct PlanEnvironment {
  std::string name;  // the file's stem; unique in the plan
  std::filesystem::path file;
  std::string split;  // "" : every split may draw it
};

/// A library of environments, sorted by name.
struct EnvironmentPool {
  std::string id;
  std::vector<PlanEnvironment> environments;
};

struct LightDraw {
  std::string pool;
  int count = 1;  // different ones, drawn anew for each set
};

/// The sets of images of every person of one split. Set k shows view k / repeat of view_count.
struct ViewSet {
  std::string split;
  int view_count = 1;
  int repeat = 1;  // sets of a view, each under lights of its own
  int size_px = 512;
  int spp = 64;
  std::optional<renderer::ErrorGoal> goal;  // instead of spp
  int max_bounces = 32;
  bool subsurface = true;
  renderer::ShadingModel shading = renderer::ShadingModel::kV1;
  std::vector<LightDraw> lights;
  std::vector<renderer::PointLight> points;
  int set_count() const { return view_count * repeat; }
};

struct Plan {
  std::filesystem::path file;
  std::string sha256;  // of the file
  std::string name;
  uint64_t seed = 1;
  MaterialTable materials{};
  int map_px = 0;                  // of the baked maps; 0: those of the diffuse picture
  std::vector<PlanPerson> people;  // sorted by id
  std::vector<EnvironmentPool> pools;
  std::vector<ViewSet> views;

  const ViewSet& views_of(const PlanPerson& person) const;
  /// Throws InputError naming the plan if there is nobody of that id.
  const PlanPerson& person(const std::string& id) const;
  size_t set_count() const;  // of all people
};

/// Reads and checks plan.xml; relative paths are relative to its folder. Every file that it names must be
/// there; pictures and meshes are not opened. Throws InputError, "file: line N: cause; mend": not
/// well-formed, unknown or missing elements and attributes, values out of range, ids that are used twice or
/// that are no plain name of a folder, files that are missing, a split without views or a draw of more lights
/// than there are.
Plan read_plan(const std::filesystem::path& file);

/// One set of images of one person: which view, under which lights, by which random numbers.
struct PlannedSet {
  int number = 0;  // file view_<number>.exr
  int view = 0;    // of ViewSet::view_count
  uint64_t seed = 0;
  std::vector<const PlanEnvironment*> environments;  // point into the plan
};

/// All sets of a person. Each is a function of the plan's seed, the person's id, the set's number and the
/// names of the environments alone: an environment more changes only the sets that draw it (rendezvous
/// hashing, Thaler and Ravishankar 1998).
std::vector<PlannedSet> sets_of(const Plan& plan, const PlanPerson& person);

/// FNV-1a of the text, its bits mixed: the same on every machine.
uint64_t hash_of_text(const std::string& text);
/// The hash as a number in [0, 1).
double share_of_hash(uint64_t hash);

}  // namespace ohb::production
