// A person as a scanner gives it: one mesh, one atlas, one picture, and the true class of each face.
#pragma once

#include "dataset/model/image.h"
#include "dataset/people/atlas.h"
#include "dataset/people/scan_faults.h"

namespace ohb::people {

struct ScannedPerson {
  std::vector<Vec3f> positions_cm;
  std::vector<Vec2f> uvs;
  std::vector<uint32_t> face_begin;  // as Scan
  std::vector<Corner> corners;
  std::vector<uint8_t> face_class;  // MaterialClass
  std::vector<std::string> part_of_face;
  ByteImage picture;  // sRGB
  float px_per_cm = 0;
  size_t unseen_faces = 0;  // that were dropped

  size_t face_count() const { return face_begin.size() - 1; }
};

struct ScanOptions {
  int atlas_px = 2048;
  ScanFaults faults;
};

/// Hides what cannot be seen, cuts hair to its outline, packs the atlas and paints the picture. Throws
/// InputError for a picture that cannot be read.
ScannedPerson scan_person(Person person, const ScanOptions& options);

}  // namespace ohb::people
