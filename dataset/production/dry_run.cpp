#include "dataset/production/dry_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "dataset/model/interrupt.h"
#include "dataset/model/stopwatch.h"
#include "dataset/model/temporary.h"
#include "dataset/production/person_renderer.h"
#include "dataset/production/shard.h"

namespace ohb::production {
namespace fs = std::filesystem;
namespace {

constexpr int kMachines[] = {1, 16, 147};

uint64_t bytes_below(const fs::path& folder) {
  uint64_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) bytes += entry.file_size();
  return bytes;
}

/// One set as a person of that split would get it.
SplitForecast measure(const Plan& plan, const ViewSet& views, const BakedPerson& baked, FileHashes& hashes,
                      Forecast& forecast, const fs::path& folder) {
  SplitForecast split;
  split.split = views.split;
  split.size_px = views.size_px;
  for (const PlanPerson& person : plan.people) split.people += person.split == views.split;
  split.sets = split.people * static_cast<size_t>(views.set_count());
  size_t lights = views.points.size();
  for (const LightDraw& draw : views.lights) lights += static_cast<size_t>(draw.count);
  split.lit_images = split.sets * lights;
  if (split.people == 0) return split;
  PlanPerson pilot = plan.people.front();
  pilot.split = views.split;
  PersonRenderer renderer(plan, pilot, baked);
  const PlannedSet set = sets_of(plan, pilot).front();
  for (const PlanEnvironment* environment : set.environments) hashes.of(environment->file);
  const Stopwatch watch;
  const fs::path file = folder / "pilot.exr";
  write_sample(file, renderer.render(set, hashes, [] { throw_if_interrupted(); }));
  split.set_s = watch.wall_s() - renderer.times().loading_s - renderer.environments().load_seconds();
  split.set_bytes = fs::file_size(file);
  if (forecast.environment_s == 0 && renderer.environments().loaded() > 0)
    forecast.environment_s =
        renderer.environments().load_seconds() / static_cast<double>(renderer.environments().loaded());
  if (&views == &plan.views.front()) forecast.person_s += renderer.times().loading_s;
  return split;
}

/// Of a person's sets: each environment once where all fit into the cache. `fits`: how many do.
size_t environment_loads(const std::vector<PlannedSet>& sets, size_t fits) {
  std::set<const PlanEnvironment*> different;
  size_t drawn = 0;
  for (const PlannedSet& set : sets) {
    drawn += set.environments.size();
    different.insert(set.environments.begin(), set.environments.end());
  }
  return different.size() <= fits ? different.size() : drawn;
}

double seconds_of(const Plan& plan, const PlanPerson& person, const Forecast& forecast, size_t fits) {
  const auto split = std::find_if(forecast.splits.begin(), forecast.splits.end(),
                                  [&](const SplitForecast& s) { return s.split == person.split; });
  const std::vector<PlannedSet> sets = sets_of(plan, person);
  return forecast.person_s + static_cast<double>(sets.size()) * split->set_s +
         static_cast<double>(environment_loads(sets, fits)) * forecast.environment_s;
}

/// How many of these environments the cache holds, by the size of the first file's picture.
size_t environments_that_fit(const Plan& plan) {
  for (const EnvironmentPool& pool : plan.pools) {
    const ImageFileInfo info = probe_image(pool.environments.front().file);
    const size_t bytes = static_cast<size_t>(info.width_px) * static_cast<size_t>(info.height_px) *
                         EnvironmentCache::kTexel_bytes;
    return EnvironmentCache::kBudget_bytes / std::max<size_t>(1, bytes);
  }
  return 0;
}

std::string size_text(uint64_t bytes) {
  const double value = static_cast<double>(bytes);
  return bytes < 1000000000 ? fmt::format("{:.1f} MB", value / 1e6) : fmt::format("{:.1f} GB", value / 1e9);
}

std::string time_text(double hours) {
  return hours < 1 ? fmt::format("{:.1f} minutes", 60 * hours) : fmt::format("{:.1f} hours", hours);
}

}  // namespace

Forecast forecast(const Plan& plan, int threads) {
  Forecast forecast;
  forecast.plan = plan.name;
  forecast.threads = threads;
  forecast.people = plan.people.size();
  forecast.sets = plan.set_count();
  for (const EnvironmentPool& pool : plan.pools) forecast.environments += pool.environments.size();
  const LockedTemporary folder(fs::temp_directory_path() / "openhumanbrdf_pilot",
                               LockedTemporary::Kind::kFolder);
  const PlanPerson& pilot = plan.people.front();
  forecast.pilot = pilot.id;
  const Layout layout{folder.path()};
  FileHashes hashes(layout.hashes(pilot.id));
  const Stopwatch watch;
  const BakedPerson baked = bake_person(plan, pilot, layout, hashes, [](const std::string&, double) {});
  forecast.person_s = watch.wall_s();
  forecast.person_bytes = bytes_below(layout.person(pilot.id));
  for (const ViewSet& views : plan.views)
    forecast.splits.push_back(measure(plan, views, baked, hashes, forecast, folder.path()));
  forecast.bytes = forecast.person_bytes * forecast.people;
  for (const SplitForecast& split : forecast.splits) forecast.bytes += split.set_bytes * split.sets;
  const size_t fits = environments_that_fit(plan);
  std::map<std::string, double> seconds;
  for (const PlanPerson& person : plan.people) seconds[person.id] = seconds_of(plan, person, forecast, fits);
  for (const int machines : kMachines) {
    double longest = 0;
    for (int i = 1; i <= machines; ++i) {
      double sum = 0;
      for (const PlanPerson* person : people_of_shard(plan, {i, machines})) sum += seconds[person->id];
      longest = std::max(longest, sum);
    }
    forecast.machines.push_back({machines, longest / 3600});
  }
  return forecast;
}

std::string to_text(const Forecast& f) {
  std::string text = fmt::format("plan '{}': {} people, {} sets, {} environments\n", f.plan, f.people, f.sets,
                                 f.environments);
  for (const SplitForecast& s : f.splits)
    text += fmt::format("  {}: {} people, {} sets, {} lit images of {} px\n", s.split, s.people, s.sets,
                        s.lit_images, s.size_px);
  text += fmt::format(
      "measured now with {} on {} threads: label, bake and load {:.1f} s, {}; an environment {:.2f} s\n",
      f.pilot, f.threads, f.person_s, size_text(f.person_bytes), f.environment_s);
  for (const SplitForecast& s : f.splits)
    if (s.people > 0)
      text += fmt::format("  a set of {}: {:.2f} s, {}\n", s.split, s.set_s, size_text(s.set_bytes));
  text += fmt::format("disk: {}\n", size_text(f.bytes));
  for (const MachinesForecast& m : f.machines)
    text += fmt::format("{} {} like this one: {}\n", m.machines, m.machines == 1 ? "machine" : "machines",
                        time_text(m.hours));
  return text;
}

nlohmann::ordered_json to_json(const Forecast& f) {
  nlohmann::ordered_json json = {{"plan", f.plan},
                                 {"people", f.people},
                                 {"sets", f.sets},
                                 {"environments", f.environments},
                                 {"pilot",
                                  {{"person", f.pilot},
                                   {"threads", f.threads},
                                   {"person_s", f.person_s},
                                   {"person_bytes", f.person_bytes},
                                   {"environment_s", f.environment_s}}},
                                 {"bytes", f.bytes}};
  for (const SplitForecast& s : f.splits)
    json["splits"].push_back({{"split", s.split},
                              {"people", s.people},
                              {"sets", s.sets},
                              {"lit_images", s.lit_images},
                              {"size_px", s.size_px},
                              {"set_s", s.set_s},
                              {"set_bytes", s.set_bytes}});
  for (const MachinesForecast& m : f.machines)
    json["machines"].push_back({{"machines", m.machines}, {"hours", m.hours}});
  return json;
}

}  // namespace ohb::production
