#include "learner/run_header.h"

#include <map>
#include <set>

#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"

namespace ohb::learner {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

/// The content of the priors' weights, in the order of the tasks.
json identity_of_priors(const std::vector<fs::path>& files_or_runs) {
  std::map<std::string, std::string> hashes;
  for (const fs::path& file : files_or_runs) {
    const LoadedNetwork loaded = load_network(file);
    hashes[name_of(loaded.network.task)] = sha256_of_file(loaded.file);
  }
  return hashes;
}

/// What the run begins with; whom that was trained on, this run's network has seen too.
void add_start(const fs::path& file_or_run, json& header) {
  const LoadedNetwork start = load_network(file_or_run);
  header["from"] = sha256_of_file(start.file);
  std::set<std::string> seen = header["trained_on"];
  for (const std::string& name : start.header.value("trained_on", std::vector<std::string>{}))
    seen.insert(name);
  header["trained_on"] = seen;
}

}  // namespace

json run_header(const TrainOptions& o, const Dataset& dataset, const Split& split, int64_t steps) {
  json header = {{"format", kCheckpointFormat},
                 {"task", name_of(o.task)},
                 {"width", o.width},
                 {"size_px", o.size_px},
                 {"batch", o.batch},
                 {"learning_rate", o.learning_rate},
                 {"weight_decay", o.weight_decay},
                 {"clip", o.clip},
                 {"warmup", o.warmup},
                 {"cosine", o.cosine},
                 {"render_weight", o.render_weight},
                 {"linear_render", o.linear_render},
                 {"guidance", o.guidance == Guidance::kTruth ? "truth" : "priors"},
                 {"mirror", o.mirror},
                 {"seed", o.seed},
                 {"trained_on", split.training},
                 {"held_out", split.held_out},
                 {"views", identity_of_views(dataset, split.training)}};
  if (o.guidance == Guidance::kPriors) header["priors"] = identity_of_priors(o.priors);
  if (o.recolour) header["recolour"] = true;
  if (o.balanced) header["balanced"] = true;
  if (o.control_roughness != kGeometryRoughness) header["control_roughness"] = o.control_roughness;
  if (o.snapshots) header["snapshots"] = true;
  if (o.parts) header["parts"] = true;
  if (o.mix_lights) header["mix_lights"] = true;
  if (!o.from.empty()) add_start(o.from, header);
  if (o.average) header["average"] = true;
  if (o.task == Task::kFinetune && o.residual) header["residual"] = true;
  // The schedule depends on the number of steps.
  if (o.cosine || o.warmup * 10 > steps) header["schedule_steps"] = steps;
  return header;
}

void check_same_run(const json& before, const json& now, const fs::path& file) {
  json wanted = now;
  for (const char* only_where_it_matters : {"schedule_steps", "recolour", "balanced", "snapshots", "parts",
                                            "mix_lights", "average", "residual", "from", "control_roughness"})
    if (before.contains(only_where_it_matters) && !now.contains(only_where_it_matters))
      wanted[only_where_it_matters] = nullptr;
  // Runs of versions before these were noted cannot be told apart by them.
  for (const char* not_always_noted : {"views", "priors"})
    if (!before.contains(not_always_noted)) wanted.erase(not_always_noted);
  if (wanted.contains("views") && before["views"] != wanted["views"])
    throw InputError(file.string(), "views",
                     "are others than those that the run was trained on: rendered again, more, or fewer",
                     "give the run's samples, or another -o for a new run");
  for (const auto& [key, value] : wanted.items())
    if (!before.contains(key) || before[key] != value)
      throw InputError(file.string(), key,
                       "is " + (before.contains(key) ? json_text(before[key]) : "unset") +
                           " in the run and " + json_text(value) + " now",
                       "give the run's options, or another -o for a new run");
}

void check_is_run(const fs::path& run, bool has_checkpoint) {
  if (has_checkpoint) return;
  for (const char* name : {kWeightsName, "log.jsonl"})
    if (fs::exists(run / name) && (name == std::string(kWeightsName) || !read_marker(run)))
      throw InputError(run.string(), "", std::string("holds ") + name + " without a checkpoint to go on from",
                       "choose another -o, or move it elsewhere");
}

}  // namespace ohb::learner
