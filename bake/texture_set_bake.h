// One texture set in the making: what its maps share, and each map on demand, so that few are in memory at
// once.
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <vector>

#include "bake/bake.h"
#include "bake/seam_fill.h"
#include "bake/seam_mend.h"
#include "bake/source_bake.h"
#include "dataset/model/model_files.h"
#include "dataset/surface/texel_coverage.h"

namespace ohb::bake {

/// The triangles of one set, and their UVs in the same order.
struct SetTriangles {
  std::vector<uint32_t> index;  // into Model::triangles
  std::vector<surface::UvTriangle> uvs;
  std::vector<std::array<uint32_t, 3>> corners;  // into Scan::corners
};

/// What the bakes of all texture sets of one scan share. Borrows all of it.
struct BakeInputs {
  const CanonicalMesh& mesh;
  const Scan& scan;
  const MaterialTable& table;
  const BakeOptions& options;
  const MeshFrames& frames;
  const SourceBake* source;  // null: the scan's own pictures
};

class SetBake {
 public:
  /// Both arguments must outlive this. Throws InputError for a picture that cannot be read, and where more
  /// texels than allowed miss the source.
  SetBake(const BakeInputs& inputs, uint16_t set, SetReport& report);

  int width_px() const { return coverage_.width_px; }
  int height_px() const { return coverage_.height_px; }
  // Finished, padded maps; empty if the set has none of this kind. Take each once, from any thread.
  Image take_albedo();
  Image take_alpha();
  Image take_normal();
  std::array<Image, kMaterialMaps.size()> take_class_maps();
  Image take_displacement();
  Image take_height();         // cm along the low mesh's normal; empty without a source
  Image take_object_normal();  // empty unless wanted
  /// The mip levels of a finished map, from level 1 down to one texel: area-weighted means, normals made unit
  /// length. Of albedo and normals the seams are mended level by level up to level 4, each level by itself,
  /// which a chain of plain means cannot reach.
  std::vector<Image> mips_of(const Image& map, const MapKind& kind);
  /// 255 where a texel has a value of its own, else 128.
  ByteImage valid() const;
  /// Colours of what each texel found, as docs/commands/bake.md lists them; empty without a source and
  /// overlaps. Before take_height.
  ByteImage debug() const;

 private:
  Image albedo();
  Image alpha();
  Image normal();
  Image class_shares() const;
  Image class_values() const;
  Image displacement();
  /// Fills the background of a map: the band beside the seams, then the rest.
  void fill_background(Image& image, const std::vector<uint8_t>& is_covered, bool is_normals) const;
  /// Mends the seams of a map with a background and reports them.
  void finish_seams(Image& image, const char* map, MapValues values);
  /// Both.
  Image finished(Image image, const char* map, const std::vector<uint8_t>& is_covered, MapValues values);
  void report_seams(MapSeams seams);
  void report_shipped(const char* map, const std::vector<SeamError>& levels);
  void look_at_seams_and_source(const SourceBake* source);
  void report_source();

  const CanonicalMesh& mesh_;
  const Scan& scan_;
  const MaterialTable& table_;
  const ScanMaterial& material_;
  surface::GreenChannel green_;
  std::filesystem::path class_weights_;  // empty: hard borders
  SetReport& report_;
  std::mutex report_mutex_;
  SetTriangles triangles_;
  surface::TexelCoverage coverage_;
  std::vector<uint8_t> has_class_,
      has_value_;                   // of each texel: a face; a face and, with a source, a point of it
  std::vector<uint8_t> is_inside_;  // of each texel: its centre lies in a triangle
  std::vector<Seam> seams_;
  std::unique_ptr<SeamBand> band_;  // null without seams
  bool mends_seams_ = false;
  std::unique_ptr<SeamMender> mender_;  // of level 0; null if seams are not mended
  bool from_source_;
  float reach_cm_ = 0;
  SourceMaps source_;
};

}  // namespace ohb::bake
