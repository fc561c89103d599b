// The colour and class of each point of a person: the assets' pictures, recoloured, patterned, made leather.
#pragma once

#include <memory>
#include <vector>

#include "dataset/people/person.h"
#include "dataset/people/picture.h"

namespace ohb::people {

/// How one part is coloured.
class Look {
 public:
  /// `part` before faces are split or dropped. Throws InputError for a picture that cannot be read.
  Look(const Person& person, const Part& part);

  /// Linear colour at a point of a face's surface. `pattern_uv` counts centimetres.
  Vec3f colour(uint8_t zone, Vec2f uv, Vec3f rest_cm) const;
  float opacity(Vec2f uv) const { return picture_->opacity(uv); }

  /// Zone of a face of the part's own mesh: 0 lower, 1 upper, kDetail and kSock for what stays as it is.
  uint8_t zone_of(uint32_t face) const { return zones_.empty() ? 0 : zones_[face]; }
  MaterialClass class_of(uint8_t zone) const;

  static constexpr uint8_t kDetail = 2, kSock = 3;

 private:
  void find_zones(const Person& person, const Part& part);
  void find_means(const Part& part);
  Vec3f garment_colour(uint8_t zone, Vec2f uv, Vec3f rest_cm) const;

  PartKind kind_;
  const WornItem* worn_;
  std::shared_ptr<const Picture> picture_;
  std::vector<uint8_t> zones_;
  Vec3f mean_[4];  // of the picture, by zone
  Vec3f target_;   // mean of skin and hair
  float cm_per_uv_ = 100;
};

}  // namespace ohb::people
