#include "dataset/production/worker.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>

#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/error.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/json_text.h"
#include "dataset/model/sample_listing.h"
#include "dataset/model/stopwatch.h"
#include "dataset/model/temporary.h"
#include "dataset/production/file_lock.h"
#include "dataset/production/person_renderer.h"
#include "dataset/production/units.h"

namespace ohb::production {
namespace fs = std::filesystem;
namespace {

constexpr const char* kListing = "listing";  // the unit of render.json

void say(const std::string& line) {
  std::printf("%s\n", line.c_str());
  std::fflush(stdout);
}

/// Says "@alive" once a second at most, from any thread, and ends the work after a signal.
class SignOfLife {
 public:
  void operator()() {
    throw_if_interrupted();
    const int64_t now =
        std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now().time_since_epoch())
            .count();
    int64_t last = last_s_;
    if (now > last && last_s_.compare_exchange_strong(last, now)) say("@alive");
  }

 private:
  std::atomic<int64_t> last_s_{0};
};

struct Work {
  const PlannedSet* set;
  std::string hash;
};

/// Sets that are not done.
std::vector<Work> missing_sets(const std::vector<PlannedSet>& sets, const std::vector<std::string>& hashes,
                               const Layout& layout, const std::string& id) {
  std::vector<Work> missing;
  for (size_t i = 0; i < sets.size(); ++i)
    if (!done_marker(layout, id, set_unit(sets[i].number), hashes[i]))
      missing.push_back({&sets[i], hashes[i]});
  return missing;
}

/// Files of units that an earlier plan had. Nothing else is removed.
void remove_strays(const std::vector<PlannedSet>& sets, const Layout& layout, const std::string& id) {
  std::set<std::string> planned{"label", "bake", kListing};
  for (const PlannedSet& set : sets) planned.insert(set_unit(set.number));
  for (const std::string& unit : marked_units(layout, id)) {
    if (planned.count(unit) > 0) continue;
    const std::optional<UnitMarker> marker = read_marker(layout, id, unit);
    for (const UnitFile& file : marker ? marker->files : std::vector<UnitFile>()) {
      std::error_code ignored;
      fs::remove(layout.root / file.path, ignored);
    }
    begin_unit(layout, id, unit);
  }
}

/// render.json: the settings that all sets share, and the sets that are done.
void write_listing(const std::vector<PlannedSet>& sets, const std::vector<std::string>& hashes,
                   PersonRenderer& renderer, FileHashes& contents, const Layout& layout,
                   const std::string& id) {
  nlohmann::ordered_json json = {{"identity", identity_of(renderer.settings())}};
  for (const auto& [name, value] : renderer.settings()) json["settings"][name] = value;
  json["views"] = nlohmann::ordered_json::array();
  for (size_t i = 0; i < sets.size(); ++i) {
    if (!done_marker(layout, id, set_unit(sets[i].number), hashes[i])) continue;
    nlohmann::ordered_json row = {{"view", sets[i].view}, {"file", set_file(sets[i].number)}};
    row["environments"] = nlohmann::ordered_json::object();
    for (const PlanEnvironment* environment : sets[i].environments)
      row["environments"][environment->name] = contents.of(environment->file);
    json["views"].push_back(std::move(row));
  }
  write_file_atomically(layout.views(id) / "render.json", json_text(json, 1) + "\n");
}

/// Gives the seconds that writing took.
double make_set(const Work& work, PersonRenderer& renderer, FileHashes& contents, const Layout& layout,
                const std::string& id, SignOfLife& alive) {
  const Stopwatch watch;
  const std::string unit = set_unit(work.set->number);
  const fs::path file = layout.views(id) / set_file(work.set->number);
  const Sample sample = renderer.render(*work.set, contents, [&] { alive(); });
  const Stopwatch writing;
  begin_unit(layout, id, unit);
  write_sample(file, sample);
  finish_unit(layout, id, unit, {file}, {work.hash, {}, {}});
  say(fmt::format("@made {} {:.3f}", unit, watch.wall_s()));
  return writing.wall_s();
}

void say_what_time_went_to(const RenderTimes& times, double writing_s) {
  const std::pair<const char*, double> parts[] = {{"loading", times.loading_s},
                                                  {"environments", times.environments_s},
                                                  {"maps", times.maps_s},
                                                  {"lights", times.lights_s},
                                                  {"writing", writing_s}};
  for (const auto& [name, seconds] : parts) say(fmt::format("@spent {} {:.3f}", name, seconds));
}

void make_views(const Plan& plan, const PlanPerson& person, const BakedPerson& baked, const Layout& layout,
                FileHashes& contents, SignOfLife& alive) {
  const std::string& id = person.id;
  const std::vector<PlannedSet> sets = sets_of(plan, person);
  PersonRenderer renderer(plan, person, baked);
  std::vector<std::string> hashes;
  std::vector<std::pair<std::string, std::string>> all;
  for (const PlannedSet& set : sets) {
    hashes.push_back(renderer.unit_hash(set, contents));
    all.emplace_back(set_unit(set.number), hashes.back());
    alive();
  }
  contents.save();
  const std::string listing_hash = hash_of_parts(all);
  remove_strays(sets, layout, id);
  const std::vector<Work> missing = missing_sets(sets, hashes, layout, id);
  say(fmt::format("@there {}", sets.size() - missing.size()));
  if (missing.empty() && done_marker(layout, id, kListing, listing_hash)) return;
  claim_folder(layout.views(id), "samples");
  // From here on the folder says what of it is of these settings, and what is left from others.
  begin_unit(layout, id, kListing);
  write_listing(sets, hashes, renderer, contents, layout, id);
  double writing_s = 0;
  for (const Work& work : missing) writing_s += make_set(work, renderer, contents, layout, id, alive);
  say_what_time_went_to(renderer.times(), writing_s);
  write_listing(sets, hashes, renderer, contents, layout, id);
  finish_unit(layout, id, kListing, {layout.views(id) / "render.json"}, {listing_hash, {}, {}});
}

}  // namespace

WorkerLine parse_worker_line(const std::string& text) {
  WorkerLine line;
  const size_t blank = text.find(' ');
  const std::string word = text.substr(0, blank),
                    rest = blank == std::string::npos ? "" : text.substr(blank + 1);
  if (word == "@alive") line.kind = WorkerLine::Kind::kAlive;
  if (word == "@busy") line.kind = WorkerLine::Kind::kBusy;
  if (word == "@there") {
    line.kind = WorkerLine::Kind::kThere;
    std::from_chars(rest.data(), rest.data() + rest.size(), line.sets);
  }
  if (word == "@made" || word == "@spent") {
    line.kind = word == "@made" ? WorkerLine::Kind::kMade : WorkerLine::Kind::kSpent;
    const size_t end = std::min(rest.find(' '), rest.size());
    line.unit = rest.substr(0, end);
    if (end < rest.size()) std::from_chars(rest.data() + end + 1, rest.data() + rest.size(), line.seconds);
  }
  return line;
}

void produce_person(const Plan& plan, const PlanPerson& person, const Layout& layout) {
  const FileLock lock(layout.locks() / person.id, FileLock::Kind::kExclusive);
  if (!lock.held()) {
    say("@busy");
    return;
  }
  for (const fs::path& folder : {layout.person(person.id), layout.views(person.id), layout.done(person.id)})
    sweep_leftovers(folder);
  FileHashes contents(layout.hashes(person.id));
  contents.learn(layout.hashes("environments"));
  SignOfLife alive;
  const BakedPerson baked =
      bake_person(plan, person, layout, contents, [&](const std::string& unit, double seconds) {
        say(fmt::format("@made {} {:.3f}", unit, seconds));
        throw_if_interrupted();
      });
  make_views(plan, person, baked, layout, contents, alive);
}

}  // namespace ohb::production
