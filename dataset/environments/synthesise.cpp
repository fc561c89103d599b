#include "dataset/environments/synthesise.h"

#include <fmt/format.h>

#include "dataset/environments/recipe.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/progress.h"
#include "dataset/model/stopwatch.h"

namespace ohb::environments {
namespace {

LibraryChange::Item synthesise(const SynthesisJob& job, uint64_t index, LibraryWriter& library) {
  const std::string made_from = fmt::format("synthesis {} of seed {}, index {} at {} px", kSynthesisVersion,
                                            job.seed, index, job.width_px);
  if (const LibraryEntry* there = library.find_made_from(made_from)) return {*there, true};
  const SynthesisedLight light = synthesised(job.seed, index, job.width_px);
  LibraryEntry entry;
  entry.id = fmt::format("s{}_{:04}_{}", job.seed, index, light.category);
  entry.category = light.category;
  entry.licence = "CC0-1.0", entry.source = "openhumanbrdf environments synthesise";
  entry.origin = light.words;
  entry.made_from = made_from;
  return {library.add(std::move(entry), light.radiance), false};
}

}  // namespace

LibraryChange synthesise_environments(const SynthesisJob& job) {
  const Stopwatch watch;
  LibraryWriter library(job.library);
  LibraryChange change;
  {
    Progress progress("environments", job.count, job.quiet);
    for (uint64_t index = 0; index < job.count; ++index) {
      throw_if_interrupted();
      change.items.push_back(synthesise(job, index, library));
      progress.add();
    }
  }
  library.write_sheet();
  change.seconds = watch.wall_s();
  return change;
}

}  // namespace ohb::environments
