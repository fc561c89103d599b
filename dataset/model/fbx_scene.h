// The objects of an FBX file and what connects them: numbered in version 7, named in version 6.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "dataset/model/fbx_file.h"

namespace ohb {

struct FbxLink {
  int64_t other = 0;
  std::string property;  // of "OP" connections
};

class FbxScene {
 public:
  /// Throws InputError.
  explicit FbxScene(const std::filesystem::path& file);
  FbxScene(const FbxScene&) = delete;
  FbxScene& operator=(const FbxScene&) = delete;

  const FbxFile& file() const { return file_; }
  bool is_version_6() const { return file_.version() < 7000; }
  const FbxNode& objects() const { return *objects_node_; }
  /// GlobalSettings; null if the file has none.
  const FbxNode* settings() const;
  /// The defaults that the file states for objects of a kind ("Material", "FbxSurfacePhong"); null if none.
  const FbxNode* defaults_of(std::string_view kind, std::string_view type) const;

  int64_t id_of(const FbxNode& object) const;
  /// Without its class: binary files write "name\0\1Class", ASCII ones "Class::name".
  std::string name_of(const FbxNode& object) const;
  /// "Mesh", "Shape", "BlendShapeChannel", ...; empty if it states none.
  std::string type_of(const FbxNode& object) const;
  /// Null if there is no object of that kind ("Model", "Geometry", ...) with that id.
  const FbxNode* object_of(int64_t id, std::string_view kind) const;

  /// What is connected to the object, and what it is connected to, in file order.
  const std::vector<FbxLink>& parts_of(int64_t id) const;
  const std::vector<FbxLink>& wholes_of(int64_t id) const;

 private:
  int64_t id_at(const FbxNode& node, size_t index) const;
  void index_connections();

  FbxFile file_;
  const FbxNode* objects_node_ = nullptr;
  std::unordered_map<std::string, int64_t> numbers_;  // of version 6's names
  std::unordered_map<int64_t, const FbxNode*> objects_;
  std::unordered_map<int64_t, std::vector<FbxLink>> parts_, wholes_;
};

}  // namespace ohb
