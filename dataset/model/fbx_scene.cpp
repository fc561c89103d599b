#include "dataset/model/fbx_scene.h"

namespace ohb {
namespace {

constexpr const char* kExportAgain = "export the scan again";

bool is_text(const FbxNode& node, size_t index) {
  return index < node.values.size() && (node.values[index].type == 'S' || node.values[index].type == 'R');
}

}  // namespace

FbxScene::FbxScene(const std::filesystem::path& file) : file_(file) {
  objects_node_ = file_.root().child("Objects");
  if (!objects_node_) file_.fail("Objects", "are missing", kExportAgain);
  for (const FbxNode& object : objects_node_->children) {
    if (object.values.empty() || (is_version_6() && !is_text(object, 0))) continue;
    if (is_version_6()) numbers_.emplace(file_.text(object, 0), static_cast<int64_t>(numbers_.size()) + 1);
    objects_.emplace(id_of(object), &object);
  }
  index_connections();
}

void FbxScene::index_connections() {
  const FbxNode* connections = file_.root().child("Connections");
  if (!connections) return;
  for (const FbxNode& c : connections->children) {
    if (c.values.size() < 3 || !is_text(c, 0)) continue;
    const std::string kind = file_.text(c, 0);
    if (kind != "OO" && kind != "OP")
      continue;  // of properties: "PP" and "PO" name one where others have an id
    const int64_t from = id_at(c, 1), to = id_at(c, 2);
    const std::string property = c.values.size() > 3 ? file_.text(c, 3) : "";
    parts_[to].push_back({from, property});
    wholes_[from].push_back({to, property});
  }
}

/// Version 6: 0 for a name that no object has ("Model::Scene", the root).
int64_t FbxScene::id_at(const FbxNode& node, size_t index) const {
  if (!is_version_6()) return file_.integer(node, index);
  const auto found = numbers_.find(is_text(node, index) ? file_.text(node, index) : "");
  return found == numbers_.end() ? 0 : found->second;
}

int64_t FbxScene::id_of(const FbxNode& object) const {
  return id_at(object, 0);
}

const FbxNode* FbxScene::settings() const {
  const FbxNode* settings = file_.root().child("GlobalSettings");
  return settings ? settings : objects_node_->child("GlobalSettings");
}

const FbxNode* FbxScene::defaults_of(std::string_view kind, std::string_view type) const {
  const FbxNode* definitions = file_.root().child("Definitions");
  if (!definitions) return nullptr;
  for (const FbxNode& object_type : definitions->children) {
    if (object_type.values.empty() || object_type.values[0].bytes != kind) continue;
    for (const FbxNode& defaults : object_type.children)
      if (defaults.name == "PropertyTemplate" && !defaults.values.empty() &&
          (defaults.values[0].bytes == type || defaults.values[0].bytes == "K" + std::string(type)))
        return &defaults;
  }
  return nullptr;
}

std::string FbxScene::name_of(const FbxNode& object) const {
  const size_t index = is_version_6() ? 0 : 1;
  std::string name = object.values.size() > index ? file_.text(object, index) : "";
  const size_t zero = name.find('\0'), colons = name.find("::");
  if (zero != std::string::npos) {
    name.resize(zero);
  } else if (colons != std::string::npos) {
    name.erase(0, colons + 2);
  }
  return name.empty() ? std::string(object.name) : name;
}

std::string FbxScene::type_of(const FbxNode& object) const {
  const size_t index = is_version_6() ? 1 : 2;
  return is_text(object, index) ? file_.text(object, index) : "";
}

const FbxNode* FbxScene::object_of(int64_t id, std::string_view kind) const {
  const auto found = objects_.find(id);
  return found != objects_.end() && found->second->name == kind ? found->second : nullptr;
}

const std::vector<FbxLink>& FbxScene::parts_of(int64_t id) const {
  static const std::vector<FbxLink> none;
  const auto found = parts_.find(id);
  return found == parts_.end() ? none : found->second;
}

const std::vector<FbxLink>& FbxScene::wholes_of(int64_t id) const {
  static const std::vector<FbxLink> none;
  const auto found = wholes_.find(id);
  return found == wholes_.end() ? none : found->second;
}

}  // namespace ohb
