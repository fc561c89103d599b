#include "dataset/people/people.h"

#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <nlohmann/json.hpp>
#include <set>

#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/data_files.h"
#include "dataset/model/error.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/json_text.h"
#include "dataset/model/parallel.h"
#include "dataset/model/progress.h"
#include "dataset/people/checks.h"
#include "dataset/people/fused.h"
#include "dataset/people/scan_files.h"

namespace ohb::people {
namespace fs = std::filesystem;
namespace {

using Clock = std::chrono::steady_clock;
/// A person that fails this often is taken as it came out last, and says so.
constexpr int kMostRedraws = 12;
/// Changes when the same seed gives another person.
constexpr int kRecipeVersion = 3;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// What the person depends on; equal to what its JSON says: it is there as asked for.
nlohmann::json request_of(const PeopleJob& job, const Assets& assets, int index) {
  return {{"seed", job.draw.seed},
          {"index", index},
          {"balanced", job.draw.balanced},
          {"atlas_px", job.scan.atlas_px},
          {"noise_cm", job.scan.faults.noise_cm},
          {"holes", job.scan.faults.holes},
          {"baked_shading", job.scan.faults.shading},
          {"fused", job.fused},
          {"preview_px", job.preview_px},
          {"recipe_version", kRecipeVersion},
          {"assets", assets.fingerprint()}};
}

bool is_there(const fs::path& folder, const std::string& name, const nlohmann::json& request) {
  for (const char* ending : {".obj", ".mtl", ".jpg", ".labels.txt", ".preview.png"})
    if (!fs::is_regular_file(folder / (name + "_scan" + ending))) return false;
  try {
    const auto json = read_json(folder / (name + "_scan.json"));
    return json.at("request") == request;
  } catch (const std::exception&) {
    return false;
  }
}

nlohmann::json credits_of(const Assets& assets, const Recipe& recipe) {
  std::set<std::string> files{recipe.skin, assets.eyes, recipe.eye_material, recipe.hair, recipe.pose};
  if (!recipe.brows.empty()) files.insert(recipe.brows);
  for (const WornItem& item : recipe.clothes) {
    files.insert(item.file);
    if (!item.material.empty()) files.insert(item.material);
    if (!item.pose.empty()) files.insert(item.pose);
  }
  nlohmann::json credits = nlohmann::json::array();
  credits.push_back(
      {{"asset", "base mesh, targets, rig"}, {"licence", "CC0 1.0"}, {"author", "MakeHuman team"}});
  for (const std::string& file : files) {
    const Credit credit = assets.credit(file);
    credits.push_back({{"asset", credit.asset}, {"licence", credit.licence}, {"author", credit.author}});
  }
  return credits;
}

nlohmann::json to_json(const PersonFaults& faults) {
  const auto rounded = [](float value) { return std::round(100.0 * static_cast<double>(value)) / 100; };
  return {{"poke_depth_cm", rounded(faults.pokes.depth_cm)},
          {"poke_area_cm2", rounded(faults.pokes.area_cm2)},
          {"limb_depth_cm", rounded(faults.limb_depth_cm)},
          {"limb_vertices", faults.limb_vertices},
          {"hair_gap_cm", rounded(faults.hair_gap_cm)}};
}

MadePerson make_person(const PeopleJob& job, const Assets& assets, int index) {
  const auto start = Clock::now();
  MadePerson made;
  made.recipe = draw_recipe(assets, job.draw, index, 0);
  made.name = made.recipe.name;
  const fs::path folder = job.output / made.name;
  const nlohmann::json request = request_of(job, assets, index);
  made.was_there = is_there(folder, made.name, request);
  if (made.was_there) return made;
  AtomicFolder whole(folder, "person");
  Person person;
  PersonFaults faults;
  nlohmann::json redrawn = nlohmann::json::array();
  for (int redraws = 0; redraws <= kMostRedraws; ++redraws) {
    throw_if_interrupted();
    made.recipe = draw_recipe(assets, job.draw, index, redraws);
    person = dress_person(assets, made.recipe);
    settle_layers(person);
    faults = find_faults(assets, person);
    const std::string verdict = faults.verdict();
    if (verdict.empty()) break;
    redrawn.push_back(verdict);
  }
  throw_if_interrupted();
  ScannedPerson scan = scan_person(std::move(person), job.scan);
  if (job.fused) scan = fused(scan);
  nlohmann::json extra = {{"recipe", to_json(made.recipe)},
                          {"checks", to_json(faults)},
                          {"redrawn_because", redrawn},
                          {"credits", credits_of(assets, made.recipe)},
                          {"request", request},
                          {"tool_version", OHB_VERSION}};
  write_png(whole.path() / (made.name + "_scan.preview.png"), preview(scan, job.preview_px));
  write_scan(whole.path(), made.name, scan, extra);
  whole.commit();
  made.seconds = seconds_since(start);
  return made;
}

/// The previews side by side.
void write_contact_sheet(const PeopleJob& job, const std::vector<MadePerson>& people) {
  const int columns =
      std::max(1, static_cast<int>(std::ceil(std::sqrt(1.6 * static_cast<double>(people.size())))));
  const int rows = (static_cast<int>(people.size()) + columns - 1) / columns;
  // People are narrower than their square preview: the middle 60 % is shown.
  const int tile = std::min(job.preview_px, 16384 / std::max(columns, rows)), width = tile * 6 / 10;
  ByteImage sheet(columns * width, rows * tile, 3);
  for (size_t i = 0; i < people.size(); ++i) {
    const std::string& name = people[i].name;
    const Image image = read_image(job.output / name / (name + "_scan.preview.png"));
    if (i == 0)  // what the last row leaves empty is grey as the previews' background
      std::fill(sheet.values.begin(), sheet.values.end(),
                static_cast<uint8_t>(std::lround(255 * image.pixel(0, 0)[0])));
    const int left = static_cast<int>(i) % columns * width, top = static_cast<int>(i) / columns * tile;
    for (int y = 0; y < tile; ++y)
      for (int x = 0; x < width; ++x) {
        const int column = std::min((x + (tile - width) / 2) * image.width_px / tile, image.width_px - 1);
        const float* from = image.pixel(column, y * image.height_px / tile);
        uint8_t* to = &sheet.values[3 * (static_cast<size_t>(top + y) * static_cast<size_t>(sheet.width_px) +
                                         static_cast<size_t>(left + x))];
        for (int c = 0; c < 3; ++c) to[c] = static_cast<uint8_t>(std::lround(255 * from[c]));
      }
  }
  write_png(job.output / "contact_sheet.png", sheet);
}

}  // namespace

PeopleReport make_people(const PeopleJob& job) {
  const auto start = Clock::now();
  const Assets assets(job.assets, program_file("assets/wardrobe.json"));
  claim_folder(job.output, "people");
  PeopleReport report;
  report.people.resize(static_cast<size_t>(job.count));
  {
    Progress progress("people", static_cast<size_t>(job.count), job.quiet);
    // An exception that left the loop would cancel what Embree builds in the other threads half-way.
    std::vector<std::exception_ptr> thrown(report.people.size());
    std::atomic<bool> has_failed{false};
    parallel_for_each(0, job.count, [&](int index) {
      const auto i = static_cast<size_t>(index);
      if (has_failed) return;
      try {
        report.people[i] = make_person(job, assets, index);
        progress.add();
      } catch (...) {
        thrown[i] = std::current_exception();
        has_failed = true;
      }
    });
    for (const std::exception_ptr& exception : thrown)
      if (exception) std::rethrow_exception(exception);
  }
  write_contact_sheet(job, report.people);
  report.seconds = seconds_since(start);
  nlohmann::json index = to_json(report);
  index.erase("seconds");
  for (nlohmann::json& person : index["people"]) person.erase("was_there"), person.erase("seconds");
  write_file_atomically(job.output / "people.json", json_text(index, 1) + "\n");
  return report;
}

nlohmann::json to_json(const PeopleReport& report) {
  nlohmann::json people = nlohmann::json::array();
  for (const MadePerson& made : report.people)
    people.push_back({{"name", made.name},
                      {"scan", made.name + "/" + made.name + "_scan.obj"},
                      {"labels", made.name + "/" + made.name + "_scan.labels.txt"},
                      {"sex", made.recipe.is_female ? "female" : "male"},
                      {"group", kGroupNames[made.recipe.group]},
                      {"years", made.recipe.years},
                      {"was_there", made.was_there},
                      {"seconds", std::round(100 * made.seconds) / 100}});
  return {{"people", people}, {"seconds", std::round(10 * report.seconds) / 10}};
}

}  // namespace ohb::people
