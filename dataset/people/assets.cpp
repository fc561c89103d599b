#include "dataset/people/assets.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"
#include "dataset/people/asset_file.h"

namespace ohb::people {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::json;
constexpr const char* kLayout =
    "give the folder that holds 3dobjs, targets, rigs, clothes, hair, skins and eyes";

template <typename Value>
Value one_of(const std::string& word, const std::vector<std::pair<const char*, Value>>& words) {
  for (const auto& [name, value] : words)
    if (word == name) return value;
  throw InputError("", "'" + word + "'", "is not a word of the wardrobe", "see assets/wardrobe.json");
}

Slot slot_of(const std::string& word) {
  return one_of<Slot>(word, {{"legs", Slot::kLegs},
                             {"shoes", Slot::kShoes},
                             {"top", Slot::kTop},
                             {"suit", Slot::kSuit},
                             {"dress", Slot::kDress},
                             {"coat", Slot::kCoat},
                             {"hat", Slot::kHat}});
}

LookKind look_of(const std::string& word) {
  return one_of<LookKind>(
      word, {{"as_it_is", kAsItIs}, {"colour", kColour}, {"pattern", kPattern}, {"leather", kLeatherLook}});
}

WardrobeItem item_of(const Json& json) {
  WardrobeItem item;
  item.file = json.at("file").get<std::string>();
  item.sex = json.value("sex", "any");
  if (json.contains("slot")) item.slot = slot_of(json.at("slot").get<std::string>());
  if (json.contains("may"))
    for (const Json& word : json.at("may")) item.may.push_back(look_of(word.get<std::string>()));
  item.is_leather = json.value("material", "") == "leather";
  item.pictures = json.value("pictures", std::vector<std::string>());
  item.pose = json.value("pose", "");
  item.goes_under_hats = json.value("under_hat", false);
  item.people = json.value("people", "");
  item.age = json.value("age", "");
  item.is_light = json.value("light", 0) != 0;
  return item;
}

/// Those of the list that are in the folder.
std::vector<WardrobeItem> items_of(const Json& list, const fs::path& folder) {
  std::vector<WardrobeItem> items;
  for (const Json& json : list) {
    WardrobeItem item = item_of(json);
    const auto is_missing = [&](const std::string& name) { return !fs::is_regular_file(folder / name); };
    if (is_missing(item.file) || (!item.pose.empty() && is_missing(item.pose))) continue;
    item.pictures.erase(std::remove_if(item.pictures.begin(), item.pictures.end(), is_missing),
                        item.pictures.end());
    items.push_back(std::move(item));
  }
  return items;
}

}  // namespace

Assets::Assets(const fs::path& folder, const fs::path& wardrobe)
    : folder_(fs::absolute(folder).lexically_normal()) {
  if (!fs::is_directory(folder_)) throw InputError(folder.string(), "", "is not a folder", kLayout);
  const fs::path mesh = folder_ / "3dobjs/base.obj", rig = folder_ / "rigs/default.mhskel",
                 weights = folder_ / "rigs/default_weights.mhw";
  for (const fs::path& file : {mesh, rig, weights})
    if (!fs::is_regular_file(file)) throw InputError(file.string(), "", "is not there", kLayout);
  base_ = read_base_mesh(mesh);
  targets_ = std::make_unique<MorphTargets>(folder_ / "targets", base_.mesh.positions.size());
  skeleton_ = read_skeleton(rig, weights, base_.mesh.positions.size());
  read_wardrobe(wardrobe);
  read_credits();
  check();
  fingerprint_ = sha256_of_file(wardrobe).substr(0, 16) + sha256_of_file(mesh).substr(0, 16) +
                 sha256_of_file(weights).substr(0, 16);
}

void Assets::read_wardrobe(const fs::path& file) {
  try {
    const Json json = parse_json(read_file(file), file.string());
    skins = items_of(json.at("skins"), folder_);
    hair = items_of(json.at("hair"), folder_);
    brows = items_of(json.at("brows"), folder_);
    clothes = items_of(json.at("clothes"), folder_);
    poses = items_of(json.at("poses"), folder_);
    eyes = json.at("eyes").at("file").get<std::string>();
    eye_materials = items_of(json.at("eyes").at("materials"), folder_);
    read_face_sliders(json.at("faces").get<std::vector<std::string>>());
  } catch (const Json::exception& error) {
    throw InputError(file.string(), "", error.what(), "write it as assets/wardrobe.json is written");
  } catch (const InputError& error) {
    throw InputError(file.string(), "", error.what(), "");
  }
}

void Assets::read_face_sliders(const std::vector<std::string>& groups) {
  const fs::path file = folder_ / "modifiers/modeling_modifiers.json";
  if (!fs::is_regular_file(file)) return;  // faces then differ by the macro sliders alone
  try {
    for (const Json& group : parse_json(read_asset_text(file), file.string())) {
      const std::string name = group.at("group").get<std::string>();
      if (std::find(groups.begin(), groups.end(), name) == groups.end()) continue;
      for (const Json& slider : group.at("modifiers")) {
        if (!slider.contains("target")) continue;
        const std::string target = name + "/" + slider.at("target").get<std::string>();
        if (!slider.contains("min"))
          face_sliders.push_back({"", target});
        else
          face_sliders.push_back({target + "-" + slider.at("min").get<std::string>(),
                                  target + "-" + slider.at("max").get<std::string>()});
      }
    }
  } catch (const Json::exception& error) {
    throw InputError(file.string(), "", error.what(), "take MakeHuman's own modifiers");
  }
}

void Assets::read_credits() {
  const fs::path file = folder_ / "CREDITS.tsv";
  if (!fs::is_regular_file(file)) return;
  const std::string text = read_file(file);
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    std::vector<std::string> cells(1);
    for (size_t i = begin; i < end; ++i) {
      if (text[i] == '\t')
        cells.emplace_back();
      else
        cells.back() += text[i];
    }
    if (cells.size() >= 5) credits_[cells[0]] = {cells[2], cells[4], cells[3]};
    begin = end + 1;
  }
}

Credit Assets::credit(const std::string& file) const {
  for (std::string path = file; !path.empty();) {
    const auto found = credits_.find(path);
    if (found != credits_.end()) return {file, found->second.licence, found->second.author};
    const size_t slash = path.rfind('/');
    path = slash == std::string::npos ? "" : path.substr(0, slash);
  }
  Credit credit{file, "not stated", ""};
  // What the file's own head says: "# license CC0", "# author: name".
  const std::string text = read_asset_text(folder_ / file).substr(0, 4096);
  for (const auto& [key, value] :
       {std::pair{"license", &credit.licence}, std::pair{"author", &credit.author}}) {
    const size_t at = text.find(key);
    if (at == std::string::npos) continue;
    const size_t begin = at + std::string(key).size(),
                 end = std::min(text.find_first_of("\r\n", begin), text.size());
    std::string words = text.substr(begin, end - begin);
    words.erase(0, words.find_first_not_of(": \t"));
    if (!words.empty()) *value = words;
  }
  if (text.find("explicitly released as CC0") != std::string::npos) credit.licence = "CC0 1.0";
  return credit;
}

void Assets::check() const {
  const auto need = [&](bool is_there, const char* what) {
    if (!is_there) throw InputError(folder_.string(), "", fmt::format("holds no {}", what), kLayout);
  };
  need(!poses.empty(), "pose of the wardrobe (poses/)");
  need(fs::is_regular_file(folder_ / eyes) && !eye_materials.empty(),
       "eyes (eyes/high-poly, eyes/materials)");
  for (const bool is_female : {true, false}) {
    const auto any = [&](const std::vector<WardrobeItem>& items) {
      return std::any_of(items.begin(), items.end(), [&](const auto& item) { return item.suits(is_female); });
    };
    const auto worn = [&](Slot slot) {
      return std::any_of(clothes.begin(), clothes.end(),
                         [&](const auto& item) { return item.slot == slot && item.suits(is_female); });
    };
    const std::string who = is_female ? "women" : "men";
    need(any(skins), ("skin for " + who).c_str());
    need(any(hair), ("hair for " + who).c_str());
    need(worn(Slot::kShoes), ("shoes for " + who).c_str());
    need(worn(Slot::kSuit) || worn(Slot::kDress) || (worn(Slot::kTop) && worn(Slot::kLegs)),
         ("suit, dress, or top and trousers for " + who).c_str());
  }
}

std::shared_ptr<const Garment> Assets::garment(const std::string& file) const {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto known = garments_.find(file);
    if (known != garments_.end()) return known->second;
  }
  auto garment =
      std::make_shared<const Garment>(read_garment(folder_, folder_ / file, base_.mesh.positions.size()));
  const std::lock_guard<std::mutex> lock(mutex_);
  return garments_.emplace(file, std::move(garment)).first->second;
}

}  // namespace ohb::people
