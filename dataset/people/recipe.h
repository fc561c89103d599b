// What a person is: drawn from a seed, written beside the scan, and all that building it needs.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "dataset/people/assets.h"

namespace ohb::people {

/// The six groups of the paper.
constexpr int kGroupCount = 6;
extern const char* const kGroupNames[kGroupCount];

/// How one zone (upper or lower half) of a garment looks. Colours are linear Rec. 709.
struct ZoneLook {
  LookKind kind = kAsItIs;
  Vec3f colour{1, 1, 1}, second{1, 1, 1};
  int pattern = 0;        // of kPattern: 0 stripes across, 1 stripes along, 2 checks, 3 dots, 4 blocks
  float pattern_cm = 4;   // its period
  float grain_cm = 0.4f;  // of leather
};

struct WornItem {
  std::string file;      // .mhclo
  std::string material;  // .mhmat; empty: the garment's own
  Slot slot = Slot::kTop;
  bool is_leather = false;  // where it is as it is
  ZoneLook zones[2];        // below and above the hips
  std::string pose;
};

struct JointTurn {
  std::string bone;
  Vec3f axis;
  float degrees = 0;
};

struct Recipe {
  uint64_t seed = 1;
  int index = 0, redraws = 0;
  std::string name;  // p0003_f27_indian
  bool is_female = false;
  int group = 0;
  int years = 30;
  BodySliders body;
  float height_cm = 170;
  std::vector<WeightedTarget> face;
  std::string skin;
  Vec3f skin_tone;  // linear mean of the skin's colour
  std::string eye_material, hair, brows;
  Vec3f hair_colour;
  std::vector<WornItem> clothes;  // inner ones first
  std::string pose;
  float pose_share = 1;  // of the way from the rest pose
  std::vector<JointTurn> turns;
};

struct DrawOptions {
  uint64_t seed = 1;
  bool balanced = false;  // sex and group by turns, else at random
};

/// The recipe of person `index`: a function of seed, index and redraws alone. Sex, group, age and name do not
/// change with redraws.
Recipe draw_recipe(const Assets& assets, const DrawOptions& options, int index, int redraws);

nlohmann::json to_json(const Recipe& recipe);

}  // namespace ohb::people
