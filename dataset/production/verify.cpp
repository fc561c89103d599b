#include "dataset/production/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/parallel.h"
#include "dataset/model/progress.h"
#include "dataset/model/sample_listing.h"
#include "dataset/production/manifest.h"
#include "dataset/production/person_renderer.h"
#include "dataset/production/sample_checks.h"
#include "dataset/production/units.h"

namespace ohb::production {
namespace fs = std::filesystem;
namespace {

/// A set with its place, for checks in any order.
struct SetToCheck {
  const PlanPerson* person;
  PlannedSet set;
  fs::path file;
  std::string identity;  // of the listing
};

class Verification {
 public:
  Verification(const VerifyJob& job, const Plan& plan, const Layout& layout)
      : job_(job), plan_(plan), layout_(layout), contents_(layout.hashes("environments")) {}

  VerifyReport run();

 private:
  void add(const std::string& where, const std::string& what) {
    const std::lock_guard<std::mutex> lock(mutex_);
    report_.faults.push_back({where, what});
  }
  std::string name_of(const fs::path& file) const {
    return file.lexically_relative(layout_.root).generic_string();
  }
  void check_person(const PlanPerson& person);
  void check_units(const PlanPerson& person, const PersonRenderer& renderer);
  void check_files(const PlanPerson& person);
  void check_set(const SetToCheck& check);
  void check_strangers();
  void check_sets();
  void render_again();

  const VerifyJob& job_;
  const Plan& plan_;
  const Layout& layout_;
  FileHashes contents_;
  VerifyReport report_;
  std::vector<SetToCheck> sets_;
  std::map<std::string, std::string> identities_;  // of each person's model
  std::mutex mutex_;                               // of the report
};

/// Files below the person's folder must be those of the markers, with their sizes and hashes.
void Verification::check_files(const PlanPerson& person) {
  std::set<std::string> known;
  std::vector<UnitFile> files;
  for (const std::string& unit : marked_units(layout_, person.id)) {
    const std::optional<UnitMarker> marker = read_marker(layout_, person.id, unit);
    if (!marker) add(name_of(layout_.marker(person.id, unit)), "is damaged");
    for (const UnitFile& file : marker ? marker->files : std::vector<UnitFile>())
      if (known.insert(file.path).second) files.push_back(file);
  }
  parallel_for_each(0, static_cast<int>(files.size()), [&](int i) {
    const UnitFile& file = files[static_cast<size_t>(i)];
    try {
      std::error_code error;
      const uint64_t size = fs::file_size(layout_.root / file.path, error);
      if (error)
        add(file.path, "is missing");
      else if (size != file.size)
        add(file.path, fmt::format("has {} bytes, {} were written", size, file.size));
      else if (!is_interrupted() && sha256_of_file(layout_.root / file.path) != file.sha256)
        add(file.path, "has another content than was written");
    } catch (const std::exception& error) {
      add(file.path, error.what());
    }
  });
  report_.files += files.size();
  const std::string marker_of_views = name_of(layout_.views(person.id) / ".openhumanbrdf");
  std::error_code ignored;
  for (fs::recursive_directory_iterator entry(layout_.person(person.id), ignored), end;
       !ignored && entry != end; entry.increment(ignored))
    if (const std::string name = name_of(entry->path());
        entry->is_regular_file() && known.count(name) == 0 && name != marker_of_views)
      add(name, "belongs to no finished unit");
}

/// The sets must be there, of what the plan says now.
void Verification::check_units(const PlanPerson& person, const PersonRenderer& renderer) {
  std::string identity;
  try {
    if (const auto listing = read_sample_listing(layout_.views(person.id))) identity = listing->identity;
  } catch (const InputError& error) {
    add(person.id, error.what());
  }
  size_t missing = 0, outdated = 0;
  for (PlannedSet& set : sets_of(plan_, person)) {
    ++report_.planned_sets;
    const auto marker = read_marker(layout_, person.id, set_unit(set.number));
    if (!marker) {
      ++missing;
      continue;
    }
    outdated += marker->hash != renderer.unit_hash(set, contents_);
    const fs::path file = layout_.views(person.id) / set_file(set.number);
    if (fs::is_regular_file(file)) sets_.push_back({&person, std::move(set), file, identity});
  }
  if (missing > 0) add(person.id, fmt::format("{} sets are missing; `produce` makes them", missing));
  if (outdated > 0)
    add(person.id,
        fmt::format("{} sets are of another plan, light or version; `produce` makes them anew", outdated));
}

void Verification::check_person(const PlanPerson& person) {
  throw_if_interrupted();
  std::error_code ignored;
  if (fs::is_regular_file(layout_.quarantine(person.id), ignored)) {
    const std::string text = read_file(layout_.quarantine(person.id));
    add(person.id, "was given up: " + text.substr(0, text.find('\n')));
  }
  const PersonState state = state_of(plan_, person, layout_);
  if (state.identity.empty()) {
    report_.planned_sets += state.set_count;
    add(person.id, "is not baked; `produce` does that");
    return;
  }
  ++report_.people;
  identities_[person.id] = state.identity;
  check_files(person);
  check_units(person, PersonRenderer(plan_, person, {layout_.model(person.id), state.identity}));
}

void Verification::check_set(const SetToCheck& check) {
  const std::string where = name_of(check.file);
  const Sample sample = read_sample(check.file);
  std::map<std::string, std::string> says(sample.attributes.begin(), sample.attributes.end());
  if (says["ohb:human"] != check.person->id) add(where, "is of '" + says["ohb:human"] + "'");
  if (says["ohb:set.number"] != std::to_string(check.set.number))
    add(where, "is of set " + says["ohb:set.number"]);
  if (says["ohb:identity"] != check.identity) add(where, "is of other settings than render.json beside it");
  std::set<std::string> lights, planned;
  for (const SampleLight& light : sample.lights) lights.insert(light.name);
  for (const PlanEnvironment* environment : check.set.environments) planned.insert(environment->name);
  for (const renderer::PointLight& point : plan_.views_of(*check.person).points) planned.insert(point.name);
  if (lights != planned) add(where, "has other lights than the plan draws");
  for (const std::string& fault : sample_faults(sample, plan_.materials)) add(where, fault);
  const auto pixels = class_pixels(sample);
  const std::lock_guard<std::mutex> lock(mutex_);
  for (size_t c = 0; c < kClassCount; ++c) report_.class_share[c] += pixels[c];
}

void Verification::check_sets() {
  Progress progress("checking sets", sets_.size(), job_.quiet);
  parallel_for_each(0, static_cast<int>(sets_.size()), [&](int i) {
    if (is_interrupted()) return;
    const SetToCheck& check = sets_[static_cast<size_t>(i)];
    try {
      check_set(check);
    } catch (const std::exception& error) {
      add(name_of(check.file), error.what());
    }
    progress.add();
  });
  throw_if_interrupted();
  report_.sets = sets_.size();
  double sum = 0;
  for (const double pixels : report_.class_share) sum += pixels;
  for (size_t c = 0; c < kClassCount && sum > 0; ++c) {
    report_.class_share[c] /= sum;
    if (report_.class_share[c] == 0) report_.notes.push_back(std::string("nobody shows ") + kClassNames[c]);
  }
}

/// People and views that the plan has not: a reader of the folder would take them.
void Verification::check_strangers() {
  std::error_code ignored;
  for (fs::directory_iterator entry(layout_.humans(), ignored), end; !ignored && entry != end;
       entry.increment(ignored)) {
    const std::string id = entry->path().filename().string();
    if (std::none_of(plan_.people.begin(), plan_.people.end(),
                     [&](const PlanPerson& p) { return p.id == id; }))
      add("humans/" + id, "is nobody of the plan; remove it, or put it into the plan");
  }
}

void Verification::render_again() {
  std::vector<const SetToCheck*> drawn;
  for (const SetToCheck& set : sets_) drawn.push_back(&set);
  const auto key = [](const SetToCheck* s) {
    return hash_of_text("verify/" + s->person->id + "/" + std::to_string(s->set.number));
  };
  std::sort(drawn.begin(), drawn.end(), [&](auto* a, auto* b) { return key(a) < key(b); });
  drawn.resize(std::min(drawn.size(), static_cast<size_t>(job_.rerendered)));
  for (const SetToCheck* check : drawn) {
    throw_if_interrupted();
    const std::string where = name_of(check->file);
    try {
      const Sample stored = read_sample(check->file);
      PersonRenderer renderer(plan_, *check->person,
                              {layout_.model(check->person->id), identities_[check->person->id]});
      PlannedSet one = check->set, two = check->set;
      one.seed ^= 0x1111, two.seed ^= 0x2222;
      const Sample a = renderer.render(one, contents_, job_.spp, [] { throw_if_interrupted(); }),
                   b = renderer.render(two, contents_, job_.spp, [] { throw_if_interrupted(); });
      const ViewSet& views = plan_.views_of(*check->person);
      for (const std::string& fault : rerender_faults(stored, a, b, job_.spp, views.goal ? 0 : views.spp))
        add(where, fault);
      report_.rerendered.push_back(where);
    } catch (const InputError& error) {
      add(where, std::string("cannot be rendered again: ") + error.what());
    }
  }
}

VerifyReport Verification::run() {
  for (const PlanPerson& person : plan_.people) check_person(person);
  check_strangers();
  check_sets();
  render_again();
  std::sort(report_.faults.begin(), report_.faults.end(), [](const VerifyFault& a, const VerifyFault& b) {
    return std::tie(a.where, a.what) < std::tie(b.where, b.what);
  });
  return report_;
}

/// What readers know people and splits by.
void check_manifest(const Layout& layout, VerifyReport& report) {
  std::map<std::string, std::string> written;  // not known of datasets of older versions
  if (const auto marker = read_marker(layout, "", kManifestUnit))
    for (const UnitFile& file : marker->files) written[file.path] = file.sha256;
  for (const std::string name : {"dataset.xml", "splits.xml"})
    if (!fs::is_regular_file(layout.root / name))
      report.faults.push_back({name, "is missing; `produce` writes it"});
    else if (written.count(name) > 0 && sha256_of_file(layout.root / name) != written[name])
      report.faults.push_back({name, "has another content than was written; `produce` writes it anew"});
}

}  // namespace

VerifyReport verify_dataset(const VerifyJob& job) {
  const Layout layout{job.dataset};
  const Plan plan = read_plan(read_dataset_plan(layout).plan);
  VerifyReport report = Verification(job, plan, layout).run();
  check_manifest(layout, report);
  return report;
}

std::string to_text(const VerifyReport& r) {
  std::string text;
  for (const VerifyFault& fault : r.faults) text += fault.where + ": " + fault.what + "\n";
  for (const std::string& note : r.notes) text += "note: " + note + "\n";
  text += "pixels:";
  for (size_t c = 0; c < kClassCount; ++c)
    text += fmt::format(" {} {:.1f} %", kClassNames[c], 100 * r.class_share[c]);
  text += fmt::format("\n{} people, {} of {} sets, {} files checked, {} sets rendered again: {}\n", r.people,
                      r.sets, r.planned_sets, r.files, r.rerendered.size(),
                      r.faults.empty() ? "all is well" : fmt::format("{} faults", r.faults.size()));
  return text;
}

nlohmann::ordered_json to_json(const VerifyReport& r) {
  nlohmann::ordered_json json = {{"people", r.people},
                                 {"sets", r.sets},
                                 {"planned_sets", r.planned_sets},
                                 {"files", r.files},
                                 {"rerendered", r.rerendered},
                                 {"notes", r.notes},
                                 {"faults", nlohmann::ordered_json::array()}};
  for (size_t c = 0; c < kClassCount; ++c) json["class_share"][kClassNames[c]] = r.class_share[c];
  for (const VerifyFault& fault : r.faults)
    json["faults"].push_back({{"where", fault.where}, {"what", fault.what}});
  return json;
}

}  // namespace ohb::production
