// Buffer views under EXT_meshopt_compression, decoded by the library that defines the format.
#include <meshoptimizer.h>

#include "dataset/model/gltf_file.h"
#include "dataset/model/scan_readers.h"

namespace ohb {

std::string GltfFile::decompressed(const nlohmann::json& compression, const std::string& place) const {
  const std::string_view from = stored_view(compression, place);
  const size_t count = index_or(compression, "count", 0), stride = index_or(compression, "byteStride", 0);
  const std::string mode = compression.value("mode", ""), filter = compression.value("filter", "NONE");
  const auto refuse = [&](const std::string& cause) {
    fail(place, "has EXT_meshopt_compression data " + cause, "export it again, without compression");
  };
  const bool is_attributes = mode == "ATTRIBUTES", is_triangles = mode == "TRIANGLES";
  if (!is_attributes && !is_triangles && mode != "INDICES") refuse("of the unknown mode '" + mode + "'");
  const bool is_stride_known =
      is_attributes ? stride > 0 && stride <= 256 && stride % 4 == 0 : stride == 2 || stride == 4;
  if (!is_stride_known || count > 3 * kMaxScanElements || (is_triangles && count % 3 != 0))
    refuse("of " + std::to_string(count) + " elements of " + std::to_string(stride) + " bytes");
  // The format's best case: two bits for 16 bytes.
  if (count * stride > 80 * from.size() + 65536)
    refuse("that is too short: " + std::to_string(from.size()) + " bytes");
  const size_t padded = (count + 3) / 4 * 4;  // the filters work on four at a time
  std::string bytes(padded * stride, '\0');
  const auto* const source = reinterpret_cast<const unsigned char*>(from.data());
  int status = 0;
  if (count == 0) return bytes;
  if (is_attributes)
    status = meshopt_decodeVertexBuffer(bytes.data(), count, stride, source, from.size());
  else if (is_triangles)
    status = meshopt_decodeIndexBuffer(bytes.data(), count, stride, source, from.size());
  else
    status = meshopt_decodeIndexSequence(bytes.data(), count, stride, source, from.size());
  if (status != 0) refuse("that cannot be decoded");
  if (filter == "OCTAHEDRAL" && is_attributes && (stride == 4 || stride == 8))
    meshopt_decodeFilterOct(bytes.data(), padded, stride);
  else if (filter == "QUATERNION" && is_attributes && stride == 8)
    meshopt_decodeFilterQuat(bytes.data(), padded, stride);
  else if (filter == "EXPONENTIAL" && is_attributes)
    meshopt_decodeFilterExp(bytes.data(), padded, stride);
  else if (filter != "NONE")
    refuse("with the unknown filter '" + filter + "'");
  bytes.resize(count * stride);
  return bytes;
}

}  // namespace ohb
