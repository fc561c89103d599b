#include "dataset/production/status.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "dataset/model/atomic_file.h"
#include "dataset/production/manifest.h"
#include "dataset/production/units.h"

namespace ohb::production {
namespace fs = std::filesystem;
namespace {

constexpr double kLook_s = 600;
constexpr size_t kBar = 24;

/// Files that some process of this machine holds a flock on, as /proc/locks names them.
std::set<std::string> locked_files() {
  std::set<std::string> names;
  std::ifstream stream("/proc/locks");
  for (std::string line; std::getline(stream, line);) {
    std::istringstream words(line);
    std::string number, kind, mode, access, process, file;
    words >> number >> kind >> mode >> access >> process >> file;
    if (kind == "FLOCK") names.insert(file);
  }
  return names;
}

bool is_locked(const fs::path& file, const std::set<std::string>& locked) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return false;
  return locked.count(
             fmt::format("{:02x}:{:02x}:{}", major(status.st_dev), minor(status.st_dev), status.st_ino)) > 0;
}

/// When the markers of a person's sets were written, in s since 1970.
void add_times(const Layout& layout, const std::string& id, std::vector<double>& times) {
  for (const std::string& unit : marked_units(layout, id)) {
    struct stat status {};
    if (unit.rfind("set_", 0) == 0 && ::stat(layout.marker(id, unit).c_str(), &status) == 0)
      times.push_back(static_cast<double>(status.st_mtim.tv_sec) +
                      1e-9 * static_cast<double>(status.st_mtim.tv_nsec));
  }
}

void add_rate(std::vector<double> times, DatasetStatus& status) {
  if (times.empty()) return;
  std::sort(times.begin(), times.end());
  status.idle_s = std::max(0.0, static_cast<double>(std::time(nullptr)) - times.back());
  const auto first = std::lower_bound(times.begin(), times.end(), times.back() - kLook_s);
  const auto count = static_cast<double>(times.end() - first) - 1;
  const double span_s = times.back() - *first;
  if (count < 1 || span_s <= 0) return;
  status.sets_per_hour = 3600 * count / span_s;
  status.hours_left = static_cast<double>(status.set_count - status.sets) / *status.sets_per_hour;
}

std::string first_line(const fs::path& file) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return "";
  const std::string text = read_file(file);
  return text.substr(0, text.find('\n'));
}

std::string time_text(double hours) {
  return hours < 1 ? fmt::format("{:.0f} minutes", 60 * hours) : fmt::format("{:.1f} hours", hours);
}

}  // namespace

DatasetStatus status_of(const Layout& layout) {
  const DatasetPlan made_by = read_dataset_plan(layout);
  const Plan plan = read_plan(made_by.plan);
  DatasetStatus status;
  status.plan = plan.file.string();
  status.plan_changed = plan.sha256 != made_by.sha256;
  const std::set<std::string> locked = locked_files();
  std::vector<double> times;
  for (const PlanPerson& person : plan.people) {
    const PersonState state = state_of(plan, person, layout);
    PersonStatus row{person.id,
                     person.split,
                     !state.identity.empty(),
                     std::min(state.sets, state.set_count),
                     state.set_count,
                     is_locked(layout.locks() / person.id, locked),
                     first_line(layout.quarantine(person.id))};
    status.sets += row.sets;
    status.set_count += row.set_count;
    status.done_people += state.is_done();
    add_times(layout, person.id, times);
    status.people.push_back(std::move(row));
  }
  add_rate(std::move(times), status);
  return status;
}

std::string to_text(const DatasetStatus& s) {
  std::string text;
  size_t width = 0;
  for (const PersonStatus& p : s.people) width = std::max(width, p.id.size());
  for (const PersonStatus& p : s.people) {
    const size_t full = p.set_count > 0 ? kBar * p.sets / p.set_count : kBar;
    const char* state = !p.failure.empty()         ? "given up"
                        : p.is_at_work             ? "at work"
                        : p.sets == p.set_count    ? "done"
                        : p.is_baked || p.sets > 0 ? "begun"
                                                   : "";
    text += fmt::format("{:<{}} {:<5} [{}{}] {:>5} of {:<5} {}\n", p.id, width, p.split,
                        std::string(full, '#'), std::string(kBar - full, '.'), p.sets, p.set_count, state);
  }
  for (const PersonStatus& p : s.people)
    if (!p.failure.empty()) text += p.id + ": given up: " + p.failure + "\n";
  text += fmt::format("{} of {} people, {} of {} sets", s.done_people, s.people.size(), s.sets, s.set_count);
  if (s.sets_per_hour && s.sets < s.set_count)
    text += fmt::format("; {:.0f} sets an hour, {} left", *s.sets_per_hour, time_text(*s.hours_left));
  if (s.idle_s && s.sets < s.set_count) text += fmt::format("; the last set {:.0f} s ago", *s.idle_s);
  text += "\n";
  if (s.plan_changed)
    text += s.plan + " was changed since: what that touches is made again by the next `produce`\n";
  return text;
}

nlohmann::ordered_json to_json(const DatasetStatus& s) {
  nlohmann::ordered_json json = {{"plan", s.plan},
                                 {"plan_changed", s.plan_changed},
                                 {"sets", s.sets},
                                 {"planned_sets", s.set_count},
                                 {"done_people", s.done_people}};
  if (s.sets_per_hour) json["sets_per_hour"] = *s.sets_per_hour, json["hours_left"] = *s.hours_left;
  if (s.idle_s) json["idle_s"] = *s.idle_s;
  for (const PersonStatus& p : s.people) {
    json["people"].push_back({{"id", p.id},
                              {"split", p.split},
                              {"baked", p.is_baked},
                              {"sets", p.sets},
                              {"planned_sets", p.set_count},
                              {"at_work", p.is_at_work}});
    if (!p.failure.empty()) json["people"].back()["failure"] = p.failure;
  }
  return json;
}

}  // namespace ohb::production
