// Environments with their sampling tables, kept from set to set: loading one takes as long as many paths.
#pragma once

#include <filesystem>
#include <list>
#include <memory>
#include <string>
#include <vector>

#include "renderer/lights.h"

namespace ohb::production {

class EnvironmentCache {
 public:
  static constexpr size_t kBudget_bytes = size_t{1} << 30;
  /// A texel as EnvironmentLight keeps it, and its place in the tables.
  static constexpr size_t kTexel_bytes = 24;

  /// The environments of these files and the point lights, ready for render_lights, in this order. `sha256`
  /// are the contents that the caller reckons with. Least recently used ones make room. Throws as
  /// read_environment; TryAgainError if a file changed since it was hashed.
  std::shared_ptr<const renderer::LightSet> take(const std::vector<std::filesystem::path>& files,
                                                 const std::vector<std::string>& sha256,
                                                 const std::vector<renderer::PointLight>& points);
  /// Gives the environments of the last take() back, for the next one.
  void give_back();

  double load_seconds() const { return load_seconds_; }
  size_t loaded() const { return loaded_; }

 private:
  struct Entry {
    std::string key;
    size_t bytes = 0;
    std::unique_ptr<renderer::EnvironmentLight> light;  // none while it is lent
  };
  Entry load(const std::filesystem::path& file, const std::string& sha256);
  void make_room();

  std::list<Entry> entries_;  // the most recently used first
  std::vector<std::string> lent_keys_;
  std::shared_ptr<renderer::LightSet> lent_;
  double load_seconds_ = 0;
  size_t loaded_ = 0;
};

}  // namespace ohb::production
