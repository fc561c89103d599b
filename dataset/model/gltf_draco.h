// A primitive's triangles under KHR_draco_mesh_compression.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

namespace ohb {

/// Faces in the order that the compressed data holds them.
class DracoMesh {
 public:
  /// Decodes. Throws std::runtime_error with the library's words; never more than kMaxScanElements.
  explicit DracoMesh(std::string_view bytes);
  ~DracoMesh();
  DracoMesh(DracoMesh&&) noexcept;
  DracoMesh& operator=(DracoMesh&&) noexcept;

  size_t point_count() const;
  std::vector<uint32_t> indices() const;
  /// Numbers of the attribute with that unique id, `components` a point; normalised integers become
  /// fractions. Throws std::runtime_error if there is none.
  std::vector<float> floats(size_t id, size_t components) const;
  /// Numbers a point has of it; 0: no such attribute.
  size_t components(size_t id) const;

 private:
  struct Decoded;
  std::unique_ptr<Decoded> decoded_;
};

}  // namespace ohb
