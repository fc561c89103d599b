// One person from scan to images, in a process of its own: what it does not free, and what kills it, ends
// with it.
#pragma once

#include <functional>
#include <string>

#include "dataset/production/layout.h"
#include "dataset/production/plan.h"

namespace ohb::production {

/// What a worker tells its supervisor, a line each on stdout.
struct WorkerLine {
  enum class Kind {
    kAlive,  // "@alive": a sign of life, once a second at most
    kThere,  // "@there 12": so many sets were there
    kMade,   // "@made set_003 1.25": a unit and its seconds
    kSpent,  // "@spent lights 71.5": what seconds of all its sets together went to
    kBusy,   // "@busy": another process makes this person
    kOther   // words for people
  } kind = Kind::kOther;
  size_t sets = 0;
  std::string unit;  // or what they went to
  double seconds = 0;
};
WorkerLine parse_worker_line(const std::string& line);

/// Makes what of a person is missing, or was made of other inputs, settings or versions, and says on stdout
/// how it goes. Units that the plan has no more are removed. Only one process makes a person at a time:
/// another one says so and leaves. Throws InputError (the person cannot be made: for quarantine),
/// TryAgainError (disk full, stopped by a signal; what is finished is kept).
void produce_person(const Plan& plan, const PlanPerson& person, const Layout& layout);

}  // namespace ohb::production
