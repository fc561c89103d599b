// GLB files of rigs and of compressed data, for tests.
#pragma once

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <meshoptimizer.h>

#include <cmath>

#include "tests/support/gltf_files.h"

namespace ohb {

/// Two joints: the first two vertices follow one, the others the mean of both.
inline GlbBuilder skinned_glb() {
  GlbBuilder glb;
  glb.primitive()["attributes"]["JOINTS_0"] =
      glb.add<uint8_t>({0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0}, "VEC4", 5121);
  glb.primitive()["attributes"]["WEIGHTS_0"] =
      glb.add<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0, 0.5f, 0.5f, 0, 0}, "VEC4", 5126);
  std::vector<float> inverse(32, 0.0f);
  for (size_t k = 0; k < 2; ++k)
    for (size_t i = 0; i < 4; ++i) inverse[16 * k + 5 * i] = 1;
  inverse[0] = inverse[5] = inverse[10] = 0.01f;  // bound in centimetres
  const size_t matrices = glb.add(inverse, "MAT4", 5126);
  glb.json["skins"][0] = {{"joints", {1, 2}}, {"inverseBindMatrices", matrices}};
  glb.json["nodes"][0]["skin"] = 0;
  glb.json["nodes"][0]["translation"] = {7, 7, 7};  // of no account
  const double half = std::sqrt(0.5);
  glb.json["nodes"].push_back({{"scale", {100, 100, 100}}, {"rotation", {half, 0, 0, half}}});
  glb.json["nodes"].push_back({{"translation", {0, 0, 2}}});
  glb.json["nodes"][1]["children"] = nlohmann::json::array();
  glb.json["scenes"][0]["nodes"] = {0, 1, 2};
  return glb;
}

/// Puts positions and indices under EXT_meshopt_compression, whose uncompressed buffer is not there.
inline GlbBuilder meshopt_glb() {
  GlbBuilder glb;
  const std::vector<float> points{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  std::string vertices(meshopt_encodeVertexBufferBound(4, 12), '\0'),
      indices(meshopt_encodeIndexBufferBound(6, 4), '\0');
  meshopt_encodeVertexVersion(0);
  meshopt_encodeIndexVersion(1);
  const std::vector<uint32_t> order{0, 1, 2, 0, 2, 3};
  vertices.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(vertices.data()),
                                             vertices.size(), points.data(), 4, 12));
  indices.resize(meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char*>(indices.data()), indices.size(),
                                           order.data(), 6));
  const auto compress = [&](size_t accessor, const std::string& bytes, size_t stride, size_t count,
                            const char* mode) {
    const size_t stored = glb.add_view(bytes);
    nlohmann::json compression = glb.json["bufferViews"][stored];
    compression["byteStride"] = stride;
    compression["count"] = count;
    compression["mode"] = mode;
    const size_t view = glb.json["accessors"][accessor]["bufferView"];
    glb.json["bufferViews"][view] = {{"buffer", 1},
                                     {"byteOffset", 0},
                                     {"byteLength", stride * count},
                                     {"extensions", {{"EXT_meshopt_compression", compression}}}};
  };
  compress(0, vertices, 12, 4, "ATTRIBUTES");
  const size_t order_accessor = glb.primitive()["indices"];
  glb.json["accessors"][order_accessor]["componentType"] = 5125;
  compress(order_accessor, indices, 4, 6, "TRIANGLES");
  glb.json["buffers"] = {
      nlohmann::json::object(),
      {{"byteLength", 48}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
  glb.json["extensionsRequired"] = {"EXT_meshopt_compression"};
  return glb;
}

/// Positions and faces under KHR_draco_mesh_compression, in their order; no UVs.
inline GlbBuilder draco_glb() {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(2);
  const int positions = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const float p[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  builder.SetAttributeValuesForFace(positions, draco::FaceIndex(0), p[0], p[1], p[2]);
  builder.SetAttributeValuesForFace(positions, draco::FaceIndex(1), p[0], p[2], p[3]);
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  draco::Encoder encoder;
  encoder.SetEncodingMethod(draco::MESH_SEQUENTIAL_ENCODING);
  draco::EncoderBuffer encoded;
  encoder.EncodeMeshToBuffer(*mesh, &encoded);
  GlbBuilder glb;
  glb.primitive()["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", glb.add_view(std::string(encoded.data(), encoded.size()))},
      {"attributes", {{"POSITION", mesh->attribute(positions)->unique_id()}}}};
  glb.primitive()["attributes"].erase("TEXCOORD_0");
  glb.json["accessors"][0].erase("bufferView");
  glb.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  return glb;
}

}  // namespace ohb
