#include "dataset/people/recipe.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "dataset/model/colour.h"
#include "dataset/people/random.h"
#include "dataset/people/recipe_colours.h"

namespace ohb::people {

const char* const kGroupNames[kGroupCount] = {"asian",          "black", "indian",
                                              "middle_eastern", "white", "hispanic"};

namespace {

/// Shares of MakeHuman's three races, range of skin tone (0 deep to 1 pale, see skin_tone()), height of a
/// man.
struct Group {
  float african, asian, caucasian;
  float darkest, palest;
  float man_cm;
};
constexpr Group kGroups[kGroupCount] = {
    {.02f, .95f, .03f, .58f, .92f, 172},  // asian
    {.95f, .02f, .03f, .02f, .36f, 177},  // black
    {.20f, .25f, .55f, .28f, .62f, 170},  // indian
    {.12f, .08f, .80f, .50f, .80f, 174},  // middle eastern
    {.02f, .03f, .95f, .72f, 1.0f, 179},  // white
    {.15f, .35f, .50f, .42f, .78f, 171},  // hispanic
};

void draw_body(const Group& group, Recipe& recipe, Random random) {
  BodySliders& body = recipe.body;
  body.male = recipe.is_female ? random.within(0, .08f) : random.within(.92f, 1);
  body.years = static_cast<float>(recipe.years);
  const float stray = random.within(.05f, .2f);
  const float shares[3] = {std::max(0.0f, group.african + stray * .5f * random.normal()),
                           std::max(0.0f, group.asian + stray * .5f * random.normal()),
                           std::max(0.0f, group.caucasian + stray * .5f * random.normal())};
  const float sum = shares[0] + shares[1] + shares[2];
  body.african = shares[0] / sum, body.asian = shares[1] / sum, body.caucasian = shares[2] / sum;
  const auto slider = [&](float mean, float deviation) {
    return std::clamp(mean + deviation * random.normal(), .12f, .88f);
  };
  body.muscle = slider(recipe.is_female ? .48f : .56f, .12f);
  body.weight = slider(.5f, .13f);
  body.proportions = slider(.62f, .15f);
  body.cup = slider(.5f, .14f);
  body.firmness = slider(.6f, .12f);
  recipe.height_cm = group.man_cm - (recipe.is_female ? 12.5f : 0) + 5.5f * random.normal();
}

void draw_face(const Assets& assets, Recipe& recipe, Random random) {
  for (const FaceSlider& slider : assets.face_sliders) {
    // Left and right move alike but for a little.
    const size_t slash = slider.high.find('/');
    const std::string side = slider.high.substr(slash + 1, 2);
    float value = .28f * random.normal();
    if (side == "l-" || side == "r-") {
      const std::string twin = slider.high.substr(0, slash + 1) + slider.high.substr(slash + 3);
      value = .25f * Random(recipe.seed * 131 + static_cast<uint64_t>(recipe.index), "face" + twin).normal() +
              .03f * random.normal();
    }
    const std::string& name = slider.high;
    if (name.find("age") != std::string::npos || name.find("double") != std::string::npos ||
        name.find("pointed") != std::string::npos || name.find("head-fat") != std::string::npos)
      value *= .3f;
    if (slider.low.empty()) {
      if (value > .2f) recipe.face.emplace_back(slider.high, value);
    } else if (std::fabs(value) > .02f) {
      recipe.face.emplace_back(value < 0 ? slider.low : slider.high, std::fabs(value));
    }
  }
}

void draw_skin(const Assets& assets, const Group& group, Recipe& recipe, Random random) {
  const float tone = random.within(group.darkest, group.palest);
  recipe.skin_tone = skin_tone(tone, random.within(-1, 1));
  // The picture that is nearest in tone and age; the rest is a change of colour.
  std::vector<std::string> best;
  int least = 1 << 20;
  for (const WardrobeItem& skin : assets.skins) {
    if (!skin.suits(recipe.is_female)) continue;
    int cost = 0;
    const bool is_dark = skin.people == "african";
    if (is_dark != (tone < .4f)) cost += 8;
    if (!is_dark && skin.people == "asian" && recipe.body.asian < .4f) cost += 2;
    if (!is_dark && skin.people != "asian" && recipe.body.asian > .6f && skin.people != "eurasian") cost += 2;
    const int age = skin.age == "old" ? 60 : skin.age == "middleage" ? 42 : 26;
    cost += std::abs(age - recipe.years) / 12;
    if (cost < least) best.clear(), least = cost;
    if (cost <= least + 1) best.push_back(skin.file);
  }
  recipe.skin = random.pick(best);
  std::vector<std::string> eyes;
  const bool may_be_light = recipe.body.caucasian > .7f && tone > .65f;
  for (const WardrobeItem& eye : assets.eye_materials)
    if (!eye.is_light || may_be_light) eyes.push_back(eye.file);
  if (eyes.empty()) eyes.push_back(assets.eye_materials.front().file);
  recipe.eye_material = random.pick(eyes);
  if (!assets.brows.empty()) recipe.brows = random.pick(assets.brows).file;
}

void draw_hair(const Assets& assets, Recipe& recipe, bool wears_hat, Random random) {
  std::vector<std::string> styles;
  for (const WardrobeItem& hair : assets.hair) {
    if (!hair.suits(recipe.is_female)) continue;
    if (wears_hat && !hair.goes_under_hats) continue;
    const bool is_afro = hair.file.find("afro") != std::string::npos;
    const int times = is_afro ? (recipe.body.african > .5f ? 3 : recipe.body.african > .1f ? 1 : 0) : 2;
    styles.insert(styles.end(), static_cast<size_t>(times), hair.file);
  }
  if (styles.empty())
    for (const WardrobeItem& hair : assets.hair)
      if (hair.suits(recipe.is_female)) styles.push_back(hair.file);
  recipe.hair = random.pick(styles);
  recipe.hair_colour = hair_colour(recipe.group, recipe.years, random);
}

struct Draw {
  const Assets& assets;
  const Recipe& recipe;
  Random& random;

  std::vector<const WardrobeItem*> items(Slot slot) const {
    std::vector<const WardrobeItem*> found;
    for (const WardrobeItem& item : assets.clothes)
      if (item.slot == slot && item.suits(recipe.is_female)) found.push_back(&item);
    return found;
  }
};

ZoneLook draw_zone(const std::vector<LookKind>& may, const Draw& draw) {
  ZoneLook look;
  look.kind = may.empty() ? kAsItIs : draw.random.pick(may);
  look.colour = look.kind == kLeatherLook ? leather_colour(draw.random) : cloth_colour(draw.random);
  look.second = cloth_colour(draw.random);
  look.pattern = static_cast<int>(draw.random.below(5));
  look.pattern_cm = draw.random.within(1.2f, 9);
  look.grain_cm = draw.random.within(.25f, .6f);
  return look;
}

void wear(Slot slot, const Draw& draw, std::vector<WornItem>& clothes) {
  const std::vector<const WardrobeItem*> items = draw.items(slot);
  if (items.empty()) return;
  const WardrobeItem& item = *items[draw.random.below(items.size())];
  WornItem worn;
  worn.file = item.file;
  worn.slot = slot;
  worn.is_leather = item.is_leather;
  worn.pose = item.pose;
  if (!item.pictures.empty()) worn.material = draw.random.pick(item.pictures);
  for (ZoneLook& zone : worn.zones) zone = draw_zone(item.may, draw);
  // Only suits are two garments in one; all else is of one piece.
  if (slot != Slot::kSuit) worn.zones[1] = worn.zones[0];
  clothes.push_back(std::move(worn));
}

void draw_clothes(const Assets& assets, Recipe& recipe, Random random) {
  const Draw draw{assets, recipe, random};
  const bool has_suit = !draw.items(Slot::kSuit).empty();
  const bool has_parts = !draw.items(Slot::kTop).empty() && !draw.items(Slot::kLegs).empty();
  const bool has_dress = !draw.items(Slot::kDress).empty();
  const float choice = random.unit();
  const float dress_share = has_dress ? .25f : 0,
              parts_share = has_parts ? (recipe.is_female ? .4f : .35f) : 0;
  wear(Slot::kShoes, draw, recipe.clothes);
  if (choice < dress_share || (!has_suit && !has_parts)) {
    wear(Slot::kDress, draw, recipe.clothes);
  } else if (choice < dress_share + parts_share || !has_suit) {
    wear(Slot::kLegs, draw, recipe.clothes);
    wear(Slot::kTop, draw, recipe.clothes);
  } else {
    wear(Slot::kSuit, draw, recipe.clothes);
  }
  if (random.chance(.1f)) wear(Slot::kHat, draw, recipe.clothes);
  std::stable_sort(recipe.clothes.begin(), recipe.clothes.end(),
                   [](const WornItem& a, const WornItem& b) { return a.slot < b.slot; });
}

void draw_pose(const Assets& assets, Recipe& recipe, Random random) {
  recipe.pose = random.pick(assets.poses).file;
  recipe.pose_share = random.within(.75f, 1);
  const auto turn = [&](const char* bone, Vec3f axis, float degrees) {
    recipe.turns.push_back({bone, axis, degrees * random.normal()});
  };
  turn("neck02", {0, 1, 0}, 6);
  turn("head", {0, 1, 0}, 5);
  turn("head", {1, 0, 0}, 4);
  turn("spine03", {0, 1, 0}, 3);
  turn("spine04", {0, 0, 1}, 1.5f);
  for (const char* side : {".L", ".R"}) {
    turn((std::string("upperarm01") + side).c_str(), {0, 0, 1}, 3);
    turn((std::string("upperarm01") + side).c_str(), {1, 0, 0}, 5);
    turn((std::string("lowerarm01") + side).c_str(), {1, 0, 0}, 6);
    turn((std::string("wrist") + side).c_str(), {1, 0, 0}, 5);
  }
}

}  // namespace

Recipe draw_recipe(const Assets& assets, const DrawOptions& options, int index, int redraws) {
  Recipe recipe;
  recipe.seed = options.seed;
  recipe.index = index;
  recipe.redraws = redraws;
  const uint64_t person = split_mix(split_mix(options.seed) + static_cast<uint64_t>(index));
  Random fixed(person, "who");
  recipe.is_female = fixed.chance(.5f);
  recipe.group = static_cast<int>(fixed.below(kGroupCount));
  if (options.balanced) recipe.is_female = index % 2 == 0, recipe.group = index / 2 % kGroupCount;
  recipe.years = 19 + static_cast<int>(fixed.below(32));
  recipe.name = fmt::format("p{:04d}_{}{}_{}", index, recipe.is_female ? 'f' : 'm', recipe.years,
                            kGroupNames[recipe.group]);
  const Group& group = kGroups[recipe.group];
  const uint64_t key = split_mix(person + 0x9e37u * static_cast<uint64_t>(redraws));
  draw_body(group, recipe, Random(person, "body"));
  draw_face(assets, recipe, Random(person, "face"));
  draw_skin(assets, group, recipe, Random(person, "skin"));
  draw_clothes(assets, recipe, Random(key, "clothes"));
  const bool wears_hat = recipe.clothes.back().slot == Slot::kHat;
  draw_hair(assets, recipe, wears_hat, Random(key, "hair"));
  draw_pose(assets, recipe, Random(key, "pose"));
  return recipe;
}

namespace {

nlohmann::json srgb_of(Vec3f linear) {
  nlohmann::json values = nlohmann::json::array();
  for (int i = 0; i < 3; ++i)
    values.push_back(std::lround(255 * linear_to_srgb(std::clamp(linear[i], 0.0f, 1.0f))));
  return values;
}

double rounded(float value) {
  return std::round(1000.0 * static_cast<double>(value)) / 1000;
}

nlohmann::json to_json(const ZoneLook& look) {
  constexpr const char* kKinds[] = {"as_it_is", "colour", "pattern", "leather"};
  nlohmann::json json = {{"look", kKinds[look.kind]}};
  if (look.kind != kAsItIs) json["srgb"] = srgb_of(look.colour);
  if (look.kind == kPattern) {
    json["second_srgb"] = srgb_of(look.second);
    constexpr const char* kPatterns[] = {"stripes_across", "stripes_along", "checks", "dots", "blocks"};
    json["pattern"] = kPatterns[look.pattern];
    json["pattern_cm"] = rounded(look.pattern_cm);
  }
  return json;
}

nlohmann::json to_json(const BodySliders& body) {
  return {{"male", rounded(body.male)},
          {"muscle", rounded(body.muscle)},
          {"weight", rounded(body.weight)},
          {"proportions", rounded(body.proportions)},
          {"cup", rounded(body.cup)},
          {"firmness", rounded(body.firmness)},
          {"african", rounded(body.african)},
          {"asian", rounded(body.asian)},
          {"caucasian", rounded(body.caucasian)}};
}

}  // namespace

nlohmann::json to_json(const Recipe& r) {
  nlohmann::json clothes = nlohmann::json::array(), turns = nlohmann::json::array(),
                 face = nlohmann::json::object();
  for (const WornItem& item : r.clothes) {
    nlohmann::json json = {
        {"file", item.file}, {"lower", to_json(item.zones[0])}, {"upper", to_json(item.zones[1])}};
    if (!item.material.empty()) json["material"] = item.material;
    clothes.push_back(std::move(json));
  }
  for (const JointTurn& turn : r.turns)
    turns.push_back({{"bone", turn.bone},
                     {"axis", {turn.axis.x, turn.axis.y, turn.axis.z}},
                     {"degrees", rounded(turn.degrees)}});
  for (const auto& [name, weight] : r.face) face[name] = rounded(weight);
  return {{"seed", r.seed},
          {"index", r.index},
          {"redraws", r.redraws},
          {"sex", r.is_female ? "female" : "male"},
          {"group", kGroupNames[r.group]},
          {"years", r.years},
          {"height_cm", rounded(r.height_cm)},
          {"body", to_json(r.body)},
          {"face", face},
          {"skin", r.skin},
          {"skin_srgb", srgb_of(r.skin_tone)},
          {"eyes", r.eye_material},
          {"hair", r.hair},
          {"hair_srgb", srgb_of(r.hair_colour)},
          {"brows", r.brows},
          {"clothes", clothes},
          {"pose", r.pose},
          {"pose_share", rounded(r.pose_share)},
          {"turns", turns}};
}

}  // namespace ohb::people
