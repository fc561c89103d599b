// Rules that give faces a class by names, UV place and colour: rules.xml.
//
//   <rules schema="1.0" default="fabric">
//     <rule class="skin" material="*skin*|face" />
//     <rule class="skin" words="head|hand" except="*wear|band" />
//     <rule class="leather" group="shoe*" uv_polygon="0.1,0.2 0.5,0.2 0.5,0.9" />
//     <rule class="hair" colour_space="lab" colour_low="0,-20,-20" colour_high="30,20,20" />
//   </rules>
//
// A face is taken by a rule if all its conditions hold; later rules win.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dataset/model/regions.h"
#include "dataset/model/scan.h"
#include "dataset/model/vec.h"

namespace ohb::commands {

enum class ColourSpace { kSrgb, kLab };

/// Lowest and highest value of each channel, both included: sRGB-encoded in [0,1], or CIE L*a*b* (1976) of
/// D65 with L* in [0,100].
struct ColourRange {
  ColourSpace space = ColourSpace::kSrgb;
  Vec3f low, high;
};

/// Globs know * and ?, alternatives are separated by |, case is ignored. Empty conditions always hold.
struct LabelRule {
  MaterialClass material_class = kUnlabelled;
  std::string name;                   // glob: the material or the group has such a name
  std::string material;               // glob
  std::string group;                  // glob
  std::string words;                  // whole words of the material's or the group's name (name_words.h)
  std::string except;                 // words of names that `words` does not take after all
  std::vector<Vec2f> uv_polygon;      // the mean of the face's UVs lies inside (even-odd rule)
  std::optional<ColourRange> colour;  // of the face's mean diffuse colour
  std::string text;                   // the rule as the file has it, for reports
};

struct LabelRules {
  std::vector<LabelRule> rules;
  MaterialClass default_class = kUnlabelled;  // of faces that no rule takes
  bool use_colour() const;
};

/// Throws InputError: unknown element or attribute, a rule without class or conditions, a polygon of fewer
/// than three points, a colour range that is empty.
LabelRules read_label_rules(const std::filesystem::path& file);

/// What each rule did; the faces that it matches less those that later rules took are its own.
struct RuleOutcome {
  std::vector<int> rule_of_face;  // index of the rule that decided, -1: default class
  std::vector<uint64_t> matched;  // faces, a rule
  /// Of each rule with words: the names that they took, and the word of each.
  std::vector<std::vector<std::pair<std::string, std::string>>> words;
};

/// Gives each face its class. `face_colour`: linear Rec. 709 mean of each face's diffuse colour, needed only
/// if use_colour(). Faces without UVs are in no polygon.
std::vector<uint8_t> apply_rules(const LabelRules& rules, const Scan& scan,
                                 const std::vector<Vec3f>& face_colour, RuleOutcome& outcome);

/// Whether the text matches one of the glob's alternatives.
bool matches_glob(const std::string& glob, const std::string& text);

}  // namespace ohb::commands
