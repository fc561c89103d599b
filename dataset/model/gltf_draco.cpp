#include "dataset/model/gltf_draco.h"

#include <draco/compression/decode.h>

#include <stdexcept>

#include "dataset/model/scan_readers.h"

namespace ohb {

struct DracoMesh::Decoded {
  std::unique_ptr<draco::Mesh> mesh;
};

DracoMesh::DracoMesh(std::string_view bytes) : decoded_(std::make_unique<Decoded>()) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto result = decoder.DecodeMeshFromBuffer(&buffer);
  if (!result.ok()) throw std::runtime_error(result.status().error_msg_string());
  decoded_->mesh = std::move(result).value();
  if (decoded_->mesh->num_points() > kMaxScanElements || decoded_->mesh->num_faces() > kMaxScanElements / 3)
    throw std::runtime_error("too many elements");
}

DracoMesh::~DracoMesh() = default;
DracoMesh::DracoMesh(DracoMesh&&) noexcept = default;
DracoMesh& DracoMesh::operator=(DracoMesh&&) noexcept = default;

size_t DracoMesh::point_count() const {
  return decoded_->mesh->num_points();
}

std::vector<uint32_t> DracoMesh::indices() const {
  std::vector<uint32_t> indices;
  for (draco::FaceIndex f(0); f < decoded_->mesh->num_faces(); ++f)
    for (const draco::PointIndex& point : decoded_->mesh->face(f)) indices.push_back(point.value());
  return indices;
}

size_t DracoMesh::components(size_t id) const {
  const auto* const attribute = decoded_->mesh->GetAttributeByUniqueId(static_cast<uint32_t>(id));
  return attribute ? static_cast<size_t>(attribute->num_components()) : 0;
}

std::vector<float> DracoMesh::floats(size_t id, size_t components) const {
  const auto* const attribute = decoded_->mesh->GetAttributeByUniqueId(static_cast<uint32_t>(id));
  if (!attribute || static_cast<size_t>(attribute->num_components()) != components)
    throw std::runtime_error("has no attribute " + std::to_string(id) + " of " + std::to_string(components) +
                             " components");
  std::vector<float> values(point_count() * components);
  for (draco::PointIndex point(0); point < decoded_->mesh->num_points(); ++point) {
    const draco::AttributeValueIndex index = attribute->mapped_index(point);
    if (index.value() >= attribute->size() ||
        !attribute->ConvertValue<float>(index, static_cast<int8_t>(components),
                                        &values[point.value() * components]))
      throw std::runtime_error("has an attribute that is cut off");
  }
  return values;
}

}  // namespace ohb
