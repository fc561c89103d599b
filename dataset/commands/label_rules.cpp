#include "dataset/commands/label_rules.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>
#include <sstream>

#include "dataset/commands/name_words.h"
#include "dataset/model/colour.h"
#include "dataset/model/lab_colour.h"
#include "dataset/model/text_lines.h"
#include "dataset/model/xml_document.h"

namespace ohb::commands {
namespace {

/// "1,2 3,4" as numbers, `per_point` of them a point. Throws InputError.
std::vector<float> read_points(const XmlDocument& xml, pugi::xml_node node, const char* attribute,
                               size_t per_point) {
  std::string text = xml.text(node, attribute);
  std::replace(text.begin(), text.end(), ',', ' ');
  std::vector<float> numbers;
  std::string_view rest = text;
  for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) {
    float number = 0;
    if (!parse_float(word, number) || !std::isfinite(number))
      throw xml.error(node, std::string(attribute) + ": \"" + std::string(word) + "\" is no number",
                      "write numbers, for example 0.1,0.2 0.5,0.2 0.5,0.9");
    numbers.push_back(number);
  }
  if (numbers.empty() || numbers.size() % per_point != 0)
    throw xml.error(node, std::string(attribute) + " has " + std::to_string(numbers.size()) + " numbers",
                    "write " + std::to_string(per_point) + " a point");
  return numbers;
}

std::vector<Vec2f> read_polygon(const XmlDocument& xml, pugi::xml_node node) {
  const std::vector<float> numbers = read_points(xml, node, "uv_polygon", 2);
  std::vector<Vec2f> polygon;
  for (size_t i = 0; i < numbers.size(); i += 2) polygon.push_back({numbers[i], numbers[i + 1]});
  if (polygon.size() < 3)
    throw xml.error(node, "uv_polygon has " + std::to_string(polygon.size()) + " points",
                    "give three or more");
  return polygon;
}

Vec3f read_colour(const XmlDocument& xml, pugi::xml_node node, const char* attribute) {
  const std::vector<float> numbers = read_points(xml, node, attribute, 3);
  if (numbers.size() != 3)
    throw xml.error(node, std::string(attribute) + " is not one colour", "give 3 numbers");
  return {numbers[0], numbers[1], numbers[2]};
}

ColourRange read_colour_range(const XmlDocument& xml, pugi::xml_node node) {
  const std::string space = xml.text(node, "colour_space");
  if (space != "srgb" && space != "lab")
    throw xml.error(node, "colour_space=\"" + space + "\" is not known", "use srgb or lab");
  const ColourRange range{space == "lab" ? ColourSpace::kLab : ColourSpace::kSrgb,
                          read_colour(xml, node, "colour_low"), read_colour(xml, node, "colour_high")};
  for (int i = 0; i < 3; ++i)
    if (range.low[i] > range.high[i])
      throw xml.error(node, "colour_low exceeds colour_high: no colour is in the range", "exchange them");
  return range;
}

MaterialClass read_class(const XmlDocument& xml, pugi::xml_node node, const char* attribute) {
  const std::string name = xml.text(node, attribute);
  const MaterialClass material_class = class_from_name(name);
  if (material_class == kUnlabelled)
    throw xml.error(node, std::string(attribute) + "=\"" + name + "\" is no class", "use " + class_list());
  return material_class;
}

LabelRule read_rule(const XmlDocument& xml, pugi::xml_node node) {
  xml.expect_attributes(node, {"class", "name", "material", "group", "words", "except", "uv_polygon",
                               "colour_space", "colour_low", "colour_high"});
  LabelRule rule;
  rule.material_class = read_class(xml, node, "class");
  rule.name = xml.text_or(node, "name", "");
  rule.material = xml.text_or(node, "material", "");
  rule.group = xml.text_or(node, "group", "");
  rule.words = xml.text_or(node, "words", "");
  rule.except = xml.text_or(node, "except", "");
  if (!rule.except.empty() && rule.words.empty())
    throw xml.error(node, "except without words: it takes names out of them", "give words=\"...\" too");
  if (node.attribute("uv_polygon")) rule.uv_polygon = read_polygon(xml, node);
  if (node.attribute("colour_space") || node.attribute("colour_low") || node.attribute("colour_high"))
    rule.colour = read_colour_range(xml, node);
  if (rule.name.empty() && rule.material.empty() && rule.group.empty() && rule.words.empty() &&
      rule.uv_polygon.empty() && !rule.colour)
    throw xml.error(node, "the rule has no condition",
                    "give words, name, material, group, uv_polygon or colour_..., or the default of <rules>");
  for (const pugi::xml_attribute& attribute : node.attributes())
    rule.text +=
        (rule.text.empty() ? "" : " ") + std::string(attribute.name()) + "=\"" + attribute.value() + "\"";
  return rule;
}

bool contains(const std::vector<Vec2f>& polygon, Vec2f p) {
  bool is_inside = false;
  for (size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Vec2f a = polygon[i], b = polygon[j];
    if ((a.y > p.y) == (b.y > p.y)) continue;
    if (p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)) is_inside = !is_inside;
  }
  return is_inside;
}

std::optional<Vec2f> mean_uv(const Scan& scan, size_t face) {
  Vec2f sum;
  for (uint32_t c = scan.face_begin[face]; c < scan.face_begin[face + 1]; ++c) {
    if (scan.corners[c].uv == Corner::kNoUv) return std::nullopt;
    sum = sum + scan.uvs[scan.corners[c].uv];
  }
  return sum * (1.0f / static_cast<float>(scan.face_begin[face + 1] - scan.face_begin[face]));
}

bool is_in_range(const ColourRange& range, Vec3f linear) {
  const Vec3f colour =
      range.space == ColourSpace::kLab
          ? linear_to_lab(linear)
          : Vec3f{linear_to_srgb(linear.x), linear_to_srgb(linear.y), linear_to_srgb(linear.z)};
  for (int i = 0; i < 3; ++i)
    if (colour[i] < range.low[i] || colour[i] > range.high[i]) return false;
  return true;
}

/// The answers of a rule's globs for each name, so that none is matched once a face.
std::vector<bool> matches_of(const std::string& glob, const std::vector<std::string>& names) {
  std::vector<bool> matches;
  matches.reserve(names.size());
  for (const std::string& name : names) matches.push_back(glob.empty() || matches_glob(glob, name));
  return matches;
}

/// The word of each name that the rule's words take, "" where they take none.
std::vector<std::string> words_taken(const LabelRule& rule, const std::vector<std::string>& names) {
  std::vector<std::string> taken;
  for (const std::string& name : names) {
    const std::vector<std::string> words = words_of_name(name);
    const bool is_exception = !matching_word(rule.except, words).empty();
    taken.push_back(is_exception ? "" : matching_word(rule.words, words));
  }
  return taken;
}

/// One alternative, both texts in lower case. The last * is retried ever further on.
bool matches_one(std::string_view glob, std::string_view text) {
  size_t g = 0, t = 0, star = std::string_view::npos, star_text = 0;
  while (t < text.size()) {
    if (g < glob.size() && glob[g] == '*') {
      star = g++;
      star_text = t;
    } else if (g < glob.size() && (glob[g] == '?' || glob[g] == text[t])) {
      ++g;
      ++t;
    } else if (star != std::string_view::npos) {
      g = star + 1;
      t = ++star_text;
    } else {
      return false;
    }
  }
  while (g < glob.size() && glob[g] == '*') ++g;
  return g == glob.size();
}

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// The conditions of a rule that names decide, answered once a name.
class NameConditions {
 public:
  NameConditions(const LabelRule& rule, const std::vector<std::string>& materials,
                 const std::vector<std::string>& groups)
      : materials_(materials),
        groups_(groups),
        has_words_(!rule.words.empty()),
        by_material_(matches_of(rule.material, materials)),
        by_group_(matches_of(rule.group, groups)),
        name_of_material_(matches_of(rule.name, materials)),
        name_of_group_(matches_of(rule.name, groups)),
        word_of_material_(words_taken(rule, materials)),
        word_of_group_(words_taken(rule, groups)) {}

  bool hold(uint16_t material, uint16_t group) const {
    return by_material_[material] && by_group_[group] &&
           (name_of_material_[material] || name_of_group_[group]) &&
           (!has_words_ || !word_of_material_[material].empty() || !word_of_group_[group].empty());
  }
  /// Adds the name that decided, with its word: that of the material goes first.
  void add_word(uint16_t material, uint16_t group, std::set<std::pair<std::string, std::string>>& to) const {
    if (!has_words_) return;
    const bool is_material = !word_of_material_[material].empty();
    const auto pair = is_material ? std::pair(materials_[material], word_of_material_[material])
                                  : std::pair(groups_[group], word_of_group_[group]);
    to.insert(pair);
  }

 private:
  const std::vector<std::string>&materials_, &groups_;
  const bool has_words_;
  const std::vector<bool> by_material_, by_group_, name_of_material_, name_of_group_;
  const std::vector<std::string> word_of_material_, word_of_group_;
};

}  // namespace

bool LabelRules::use_colour() const {
  return std::any_of(rules.begin(), rules.end(),
                     [](const LabelRule& rule) { return rule.colour.has_value(); });
}

bool matches_glob(const std::string& glob, const std::string& text) {
  std::stringstream alternatives(lower_case(glob));
  const std::string lower_text = lower_case(text);
  for (std::string alternative; std::getline(alternatives, alternative, '|');)
    if (matches_one(alternative, lower_text)) return true;
  return false;
}

LabelRules read_label_rules(const std::filesystem::path& file) {
  const XmlDocument xml(file, "rules");
  xml.expect_attributes(xml.root(), {"schema", "default"});
  xml.expect_children(xml.root(), {"rule"});
  LabelRules rules;
  if (xml.root().attribute("default")) rules.default_class = read_class(xml, xml.root(), "default");
  for (const pugi::xml_node& node : xml.root().children("rule")) rules.rules.push_back(read_rule(xml, node));
  if (rules.rules.empty() && rules.default_class == kUnlabelled)
    throw xml.error(xml.root(), "there is neither a rule nor a default class",
                    "add a <rule> or default=\"...\"");
  return rules;
}

std::vector<uint8_t> apply_rules(const LabelRules& rules, const Scan& scan,
                                 const std::vector<Vec3f>& face_colour, RuleOutcome& outcome) {
  const size_t faces = scan.face_count();
  std::vector<uint8_t> face_class(faces, rules.default_class);
  outcome.rule_of_face.assign(faces, -1);
  outcome.matched.assign(rules.rules.size(), 0);
  std::vector<std::string> material_names;
  for (const ScanMaterial& material : scan.materials) material_names.push_back(material.name);
  outcome.words.assign(rules.rules.size(), {});
  for (size_t r = 0; r < rules.rules.size(); ++r) {
    const LabelRule& rule = rules.rules[r];
    const NameConditions names(rule, material_names, scan.groups);
    std::set<std::pair<std::string, std::string>> words;
    for (size_t f = 0; f < faces; ++f) {
      const uint16_t material = scan.face_material[f], group = scan.face_group[f];
      if (!names.hold(material, group)) continue;
      if (!rule.uv_polygon.empty()) {
        const std::optional<Vec2f> uv = mean_uv(scan, f);
        if (!uv || !contains(rule.uv_polygon, *uv)) continue;
      }
      if (rule.colour && !is_in_range(*rule.colour, face_colour[f])) continue;
      face_class[f] = rule.material_class;
      outcome.rule_of_face[f] = static_cast<int>(r);
      ++outcome.matched[r];
      names.add_word(material, group, words);
    }
    outcome.words[r].assign(words.begin(), words.end());
  }
  return face_class;
}

}  // namespace ohb::commands
