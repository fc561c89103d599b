#include "dataset/production/environment_cache.h"

#include <algorithm>

#include "dataset/model/error.h"
#include "dataset/model/stopwatch.h"

namespace ohb::production {

EnvironmentCache::Entry EnvironmentCache::load(const std::filesystem::path& file, const std::string& sha256) {
  const Stopwatch watch;
  const Environment environment = read_environment(file);
  if (environment.sha256 != sha256)
    throw TryAgainError(file.string(), "was changed while the dataset is produced", "run the command again");
  Entry entry{file.string() + " " + sha256, environment.radiance.values.size() / 3 * kTexel_bytes,
              std::make_unique<renderer::EnvironmentLight>(environment)};
  load_seconds_ += watch.wall_s();
  ++loaded_;
  return entry;
}

void EnvironmentCache::make_room() {
  size_t bytes = 0;
  for (auto entry = entries_.begin(); entry != entries_.end();) {
    bytes += entry->bytes;
    entry = bytes > kBudget_bytes ? entries_.erase(entry) : std::next(entry);
  }
}

std::shared_ptr<const renderer::LightSet> EnvironmentCache::take(
    const std::vector<std::filesystem::path>& files, const std::vector<std::string>& sha256,
    const std::vector<renderer::PointLight>& points) {
  give_back();
  lent_ = std::make_shared<renderer::LightSet>();
  lent_->points = points;
  for (size_t i = 0; i < files.size(); ++i) {
    const std::string key = files[i].string() + " " + sha256[i];
    auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.key == key; });
    if (found == entries_.end()) {
      make_room();
      entries_.push_front(load(files[i], sha256[i]));
      found = entries_.begin();
    }
    entries_.splice(entries_.begin(), entries_, found);
    lent_->environments.push_back(std::move(*found->light));
    found->light.reset();
    lent_keys_.push_back(key);
  }
  return lent_;
}

void EnvironmentCache::give_back() {
  for (size_t i = 0; i < lent_keys_.size(); ++i)
    for (Entry& entry : entries_)
      if (entry.key == lent_keys_[i])
        entry.light = std::make_unique<renderer::EnvironmentLight>(std::move(lent_->environments[i]));
  lent_keys_.clear();
  lent_.reset();
  entries_.remove_if([](const Entry& entry) { return !entry.light; });
  make_room();
}

}  // namespace ohb::production
