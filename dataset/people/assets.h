// A folder of MakeHuman's assets: what of it the wardrobe (assets/wardrobe.json) knows, read when asked for.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "dataset/people/body.h"
#include "dataset/people/garment_file.h"
#include "dataset/people/skeleton.h"

namespace ohb::people {

/// Where a garment is worn; later ones lie outside earlier ones.
enum class Slot { kShoes, kLegs, kTop, kSuit, kDress, kCoat, kHat };

/// How a garment's picture may be changed.
enum LookKind { kAsItIs, kColour, kPattern, kLeatherLook };

/// One line of the wardrobe. Paths are relative to the assets' folder.
struct WardrobeItem {
  std::string file;
  std::string sex = "any";  // female, male, any
  Slot slot = Slot::kTop;   // of clothes
  std::vector<LookKind> may;
  bool is_leather = false;            // as it is
  std::vector<std::string> pictures;  // materials to choose from; empty: its own
  std::string pose;                   // that the feet need
  bool goes_under_hats = false;       // of hair
  std::string people, age;            // of skins: african, asian, caucasian, eurasian; young, middleage, old
  bool is_light = false;              // of eyes

  bool suits(bool is_female) const { return sex == "any" || (sex == "female") == is_female; }
};

/// A pair of targets (or one) that makes a slider of the face.
struct FaceSlider {
  std::string low, high;  // names of targets; low may be empty
};

/// Licence and author of an asset.
struct Credit {
  std::string asset, licence, author;
};

class Assets {
 public:
  /// Reads what every person needs. Throws InputError, naming the file: a folder that is none, a part without
  /// which nobody can be dressed, a malformed file.
  Assets(const std::filesystem::path& folder, const std::filesystem::path& wardrobe);

  const std::filesystem::path& folder() const { return folder_; }
  const BaseMesh& base() const { return base_; }
  const MorphTargets& targets() const { return *targets_; }
  const Skeleton& skeleton() const { return skeleton_; }
  /// Read once, then shared. Throws as read_garment.
  std::shared_ptr<const Garment> garment(const std::string& file) const;
  Credit credit(const std::string& file) const;
  /// SHA-256 over names and bytes of the wardrobe and the core files: changes when the people would.
  const std::string& fingerprint() const { return fingerprint_; }

  std::vector<WardrobeItem> skins, hair, brows, clothes, poses, eye_materials;
  std::string eyes;
  std::vector<FaceSlider> face_sliders;

 private:
  void read_wardrobe(const std::filesystem::path& file);
  void read_face_sliders(const std::vector<std::string>& groups);
  void read_credits();
  void check() const;

  std::filesystem::path folder_;
  BaseMesh base_;
  std::unique_ptr<MorphTargets> targets_;
  Skeleton skeleton_;
  std::map<std::string, Credit> credits_;  // by folder
  std::string fingerprint_;
  mutable std::mutex mutex_;
  mutable std::map<std::string, std::shared_ptr<const Garment>> garments_;
};

}  // namespace ohb::people
