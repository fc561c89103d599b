#include "dataset/environments/import.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "dataset/environments/panorama.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/file_names.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/json_text.h"
#include "dataset/model/progress.h"
#include "dataset/model/stopwatch.h"

namespace ohb::environments {
namespace fs = std::filesystem;
namespace {

constexpr size_t kLongestRights = 500;
constexpr int kImportVersion = 1;  // changes when the same file gives other bytes

struct Rights {
  std::string licence, source;
};

/// Words that go into XML, headers and cards: one line of UTF-8.
void check_words(const std::string& words, const std::string& where, const std::string& what) {
  const bool has_control = std::any_of(words.begin(), words.end(), [](unsigned char c) { return c < 32; });
  if (has_control || words.size() > kLongestRights || readable_name(words) != words)
    throw InputError(where, what, "is no line of text of at most 500 letters", "write it in one line");
}

std::string words_of(const nlohmann::json& json, const char* name, const std::string& otherwise,
                     const std::string& file) {
  if (!json.contains(name)) return otherwise;
  if (!json[name].is_string())
    throw InputError(file, std::string("\"") + name + "\"", "is no text", "write it in quotes");
  return json[name].get<std::string>();
}

Rights rights_of(const fs::path& file, const ImportJob& job) {
  Rights rights{job.licence, job.source};
  std::string where = file.string();
  fs::path beside = file, instead = file;
  beside += ".json";
  instead.replace_extension(".json");
  for (const fs::path& sidecar : {beside, instead}) {
    std::error_code ignored;
    if (!fs::exists(sidecar, ignored)) continue;
    where = sidecar.string();
    const nlohmann::json json = read_json(sidecar);
    if (!json.is_object())
      throw InputError(where, "", "is no JSON object",
                       "write {\"licence\": \"CC0-1.0\", \"source\": \"...\"}");
    rights = {words_of(json, "licence", job.licence, where), words_of(json, "source", job.source, where)};
    break;
  }
  check_words(rights.licence, where, "licence");
  check_words(rights.source, where, "source");
  if (rights.licence.empty())
    throw InputError(
        file.string(), "", "has no licence",
        "say it with --licence, or in " + beside.filename().string() + " as {\"licence\": \"CC0-1.0\"}");
  return rights;
}

std::string made_from(const std::string& sha256, int width_px) {
  return "import " + std::to_string(kImportVersion) + " of " + sha256 + " at " + std::to_string(width_px) +
         " px";
}

/// The file's stem, unless another picture has that id.
std::string free_id(const LibraryWriter& library, const fs::path& file, const std::string& sha256) {
  const std::string id = id_of_name(file.stem().string());
  const LibraryEntry* taken = library.find(id);
  if (!taken || taken->made_from.find(sha256) != std::string::npos) return id;
  return id_of_name(id.substr(0, 55)) + "_" + sha256.substr(0, 8);
}

int width_for(int own_width_px, int asked_px) {
  if (asked_px > 0) return asked_px;
  return std::clamp(own_width_px - own_width_px % 2, 2, kOwnWidth_px);
}

LibraryChange::Item import_file(const fs::path& file, const ImportJob& job, LibraryWriter& library) {
  const Rights rights = rights_of(file, job);
  const int width_px = width_for(probe_image(file).width_px, job.width_px);
  if (const LibraryEntry* there = library.find_made_from(made_from(sha256_of_file(file), width_px))) {
    const std::string id = there->id;
    library.state_rights(id, rights.licence, rights.source);
    return {*library.find(id), true};
  }
  const Panorama panorama = read_panorama(file);
  for (const std::string& warning : panorama.warnings) spdlog::warn("{}: {}", file.string(), warning);
  LibraryEntry entry;
  entry.id = free_id(library, file, panorama.sha256);
  entry.category = "imported";
  entry.licence = rights.licence, entry.source = rights.source;
  entry.origin = readable_name(file.filename().string()) + ", " + std::to_string(panorama.radiance.width_px) +
                 " x " + std::to_string(panorama.radiance.height_px) + ", " + panorama.values;
  entry.made_from = made_from(panorama.sha256, width_px);
  entry.mended = {panorama.nan, panorama.infinite, panorama.negative};
  return {library.add(std::move(entry), resampled(panorama.radiance, width_px)), false};
}

}  // namespace

LibraryChange import_environments(const ImportJob& job) {
  const Stopwatch watch;
  LibraryWriter library(job.library);
  LibraryChange change;
  std::optional<InputError> refused;
  size_t refused_count = 0;
  {
    Progress progress("environments", job.files.size(), job.quiet);
    for (const fs::path& file : job.files) {
      throw_if_interrupted();
      try {
        change.items.push_back(import_file(file, job, library));
      } catch (const InputError& error) {
        if (refused) spdlog::error("{}", refused->what());
        refused.emplace(error);
        ++refused_count;
      }
      progress.add();
    }
  }
  if (!library.entries().empty()) library.write_sheet();
  if (refused) {
    if (job.files.size() > 1)
      spdlog::warn("{} of {} files were refused, the others are in {}", refused_count, job.files.size(),
                   job.library.string());
    throw InputError(*refused);
  }
  change.seconds = watch.wall_s();
  return change;
}

nlohmann::json to_json(const LibraryEntry& entry) {
  return {{"id", entry.id},
          {"file", "envmaps/" + entry.id + ".exr"},
          {"category", entry.category},
          {"licence", entry.licence},
          {"source", entry.source},
          {"origin", entry.origin},
          {"sha256", entry.sha256},
          {"bytes", entry.bytes},
          {"width", entry.width_px},
          {"values", entry.values},
          {"mean_radiance", entry.light.mean},
          {"peak_luminance", entry.light.peak},
          {"brightest", {entry.light.brightest.x, entry.light.brightest.y, entry.light.brightest.z}},
          {"mended",
           {{"nan", entry.mended.nan},
            {"infinite", entry.mended.infinite},
            {"negative", entry.mended.negative}}}};
}

nlohmann::json to_json(const LibraryChange& change) {
  nlohmann::json items = nlohmann::json::array();
  for (const LibraryChange::Item& item : change.items) {
    items.push_back(to_json(item.entry));
    items.back()["was_there"] = item.was_there;
  }
  return {{"environments", items}, {"seconds", std::round(10 * change.seconds) / 10}};
}

}  // namespace ohb::environments
