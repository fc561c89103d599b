#include "dataset/production/supervisor.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/error.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/process.h"
#include "dataset/model/progress.h"
#include "dataset/model/stopwatch.h"
#include "dataset/production/claim.h"
#include "dataset/production/file_hashes.h"
#include "dataset/production/file_lock.h"
#include "dataset/production/layout.h"
#include "dataset/production/manifest.h"
#include "dataset/production/worker.h"

namespace ohb::production {
namespace fs = std::filesystem;
namespace {

constexpr int kRetries = 2;
constexpr size_t kKeptLines = 20;
/// In the words of every error that means a full disk (throw_write_error).
constexpr const char* kDiskFull = "free some space";

struct Task {
  const PlanPerson* person;
  int tries = 0;
};

/// A worker that shows no sign of life.
struct Stalled {};
/// Another worker found that nothing can go on.
struct Stopped {};

/// What one run of a worker came to.
struct Outcome {
  int code = 0;
  bool is_busy = false, has_stalled = false;
  std::string words;  // its last line, for people
  std::vector<std::string> lines;
};

class Supervisor {
 public:
  Supervisor(const ProduceJob& job, ProduceReport& report)
      : job_(job), report_(report), layout_{job.output}, progress_("sets", report.sets, job.quiet) {
    for (const PlanPerson* person : people_of_shard(job.plan, job.shard)) queue_.push_back({person});
  }

  /// Throws what stopped it.
  void run() {
    std::vector<std::thread> slots;
    slots.reserve(static_cast<size_t>(job_.workers));
    for (int k = 0; k < job_.workers; ++k) slots.emplace_back([this] { work(); });
    for (std::thread& slot : slots) slot.join();
    if (stop_) std::rethrow_exception(stop_);
  }

 private:
  void work();
  std::optional<Task> next();
  Outcome run_worker(const PlanPerson& person);
  void take_line(const std::string& text, Outcome& outcome, size_t& counted);
  void judge(Task task, const Outcome& outcome);
  void give_up(const PlanPerson& person, const Outcome& outcome, const std::string& reason);
  bool is_stopped() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return stop_ != nullptr;
  }

  const ProduceJob& job_;
  ProduceReport& report_;
  Layout layout_;
  Progress progress_;
  std::mutex mutex_;  // of all below, and of the report
  std::deque<Task> queue_;
  int running_ = 0;
  std::exception_ptr stop_;
};

/// Waits while others run: what they fail at may come back to the queue.
std::optional<Task> Supervisor::next() {
  for (;; ::usleep(50000)) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (stop_ || (queue_.empty() && running_ == 0)) return std::nullopt;
    if (queue_.empty()) continue;
    const Task task = queue_.front();
    queue_.pop_front();
    ++running_;
    return task;
  }
}

void Supervisor::work() {
  while (const std::optional<Task> task = next()) {
    try {
      if (sha256_of_file(job_.plan.file) != job_.plan.sha256)
        throw TryAgainError(job_.plan.file.string(), "was changed while the dataset is produced",
                            "run the command again: what the change does not touch is kept");
      judge(*task, run_worker(*task->person));
    } catch (const Stopped&) {
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!stop_) stop_ = std::current_exception();
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    --running_;
  }
}

void Supervisor::take_line(const std::string& text, Outcome& outcome, size_t& counted) {
  const WorkerLine line = parse_worker_line(text);
  const std::lock_guard<std::mutex> lock(mutex_);
  switch (line.kind) {
    case WorkerLine::Kind::kThere:
      report_.there += line.sets;
      counted += line.sets;
      progress_.add(line.sets);
      break;
    case WorkerLine::Kind::kMade:
      if (line.unit.rfind("set_", 0) != 0) {
        report_.worker_s[line.unit] += line.seconds;
        break;
      }
      ++report_.made;
      ++counted;
      progress_.add();
      break;
    case WorkerLine::Kind::kSpent:
      report_.worker_s[line.unit] += line.seconds;
      break;
    case WorkerLine::Kind::kBusy:
      outcome.is_busy = true;
      break;
    case WorkerLine::Kind::kOther:
      outcome.words = text;
      if (outcome.lines.size() == kKeptLines) outcome.lines.erase(outcome.lines.begin());
      outcome.lines.push_back(text);
      break;
    case WorkerLine::Kind::kAlive:
      break;
  }
}

Outcome Supervisor::run_worker(const PlanPerson& person) {
  // The same program, even if another one takes its place on disk meanwhile.
  const std::vector<std::string> command = {"/proc/self/exe",
                                            "produce",
                                            job_.plan.file.string(),
                                            "-o",
                                            job_.output.string(),
                                            "--worker",
                                            person.id,
                                            "--threads",
                                            std::to_string(std::max(1, job_.threads / job_.workers))};
  Outcome outcome;
  size_t counted = 0;
  auto last_sign = std::chrono::steady_clock::now();
  try {
    outcome.code = run_process(
                       command, {},
                       [&](const std::string& line) {
                         last_sign = std::chrono::steady_clock::now();
                         take_line(line, outcome, counted);
                       },
                       [&] {
                         if (is_stopped()) throw Stopped();
                         const std::chrono::duration<double> silence =
                             std::chrono::steady_clock::now() - last_sign;
                         if (silence.count() > job_.stall_s) throw Stalled();
                       })
                       .exit_code;
  } catch (const Stalled&) {
    outcome.has_stalled = true;
    outcome.code = kExitTryAgain;
  }
  return outcome;
}

void Supervisor::judge(Task task, const Outcome& outcome) {
  std::error_code ignored;
  if (outcome.code == kExitDone) {
    fs::remove(layout_.quarantine(task.person->id), ignored);
    if (!outcome.is_busy) return;
    const std::lock_guard<std::mutex> lock(mutex_);
    report_.busy.push_back(task.person->id);
    return;
  }
  throw_if_interrupted();
  if (outcome.code == kExitTryAgain && outcome.words.find(kDiskFull) != std::string::npos)
    throw TryAgainError(job_.output.string(),
                        "the disk is full (" + task.person->id + ": " + outcome.words + ")",
                        "what is finished is kept");
  const std::string reason = outcome.has_stalled ? fmt::format("no sign of life for {:g} s", job_.stall_s)
                             : outcome.code == 128 + 9
                                 ? "killed (signal 9), perhaps for memory: try fewer --workers"
                             : outcome.code > 128    ? fmt::format("killed by signal {}", outcome.code - 128)
                             : outcome.words.empty() ? fmt::format("ended with exit code {}", outcome.code)
                                                     : outcome.words;
  if (outcome.code == kExitBadInput || task.tries == kRetries) {
    give_up(*task.person, outcome, reason);
    return;
  }
  spdlog::warn("{}: {}; tried again", task.person->id, reason);
  const std::lock_guard<std::mutex> lock(mutex_);
  ++report_.retries;
  queue_.push_back({task.person, task.tries + 1});
}

void Supervisor::give_up(const PlanPerson& person, const Outcome& outcome, const std::string& reason) {
  spdlog::error("{}: given up: {}", person.id, reason);
  std::string text = reason + "\n";
  for (const std::string& line : outcome.lines) text += line + "\n";
  make_folders(layout_.quarantine(person.id).parent_path());
  write_file_atomically(layout_.quarantine(person.id), text);
  const std::lock_guard<std::mutex> lock(mutex_);
  report_.given_up.push_back({person.id, reason});
}

}  // namespace

ProduceReport produce(const ProduceJob& job) {
  const Stopwatch watch;
  ProduceReport report;
  for (const PlanPerson* person : people_of_shard(job.plan, job.shard)) {
    ++report.people;
    report.sets += static_cast<size_t>(job.plan.views_of(*person).set_count());
  }
  claim_folder(job.output, "dataset");
  const Layout layout{job.output};
  const FileLock ours(layout.locks() / fmt::format(".shard-{}-of-{}", job.shard.index, job.shard.count),
                      FileLock::Kind::kExclusive);
  if (!ours.held())
    throw TryAgainError(job.output.string(), "another `produce` of this shard is at work there",
                        "wait for it, or share the people out with --shard i/n");
  const std::unique_ptr<FileLock> plan_lock = lock_plan(job.plan, layout);
  FileHashes environments(layout.hashes("environments"));
  for (const PlanEnvironment* environment : drawn_environments(job.plan)) {
    throw_if_interrupted();
    environments.of(environment->file);
  }
  environments.save();
  Supervisor(job, report).run();
  write_manifest(job.plan, layout, environments);
  std::sort(report.given_up.begin(), report.given_up.end(),
            [](const GivenUp& a, const GivenUp& b) { return a.id < b.id; });
  report.seconds = watch.wall_s();
  return report;
}

namespace {

/// A bar for each thing that the workers' time went to, the longest first; "" if they did nothing.
std::string worker_time_text(const ProduceReport& r) {
  double sum = 0;
  std::vector<std::pair<double, std::string>> parts;
  for (const auto& [name, seconds] : r.worker_s) {
    sum += seconds;
    parts.emplace_back(seconds, name);
  }
  std::sort(parts.rbegin(), parts.rend());
  std::string text;
  for (const auto& [seconds, name] : parts)
    text += fmt::format("  {:<13}{:>5.1f} %  {}\n", name, 100 * seconds / sum,
                        std::string(static_cast<size_t>(40 * seconds / sum), '#'));
  return sum > 0 ? fmt::format("what the workers' {:.0f} s went to:\n", sum) + text : "";
}

}  // namespace

std::string to_text(const ProduceReport& r, const fs::path& output) {
  std::string text = fmt::format("{}: {} people, {} sets: {} made, {} were there, {:.0f} s\n",
                                 output.string(), r.people, r.sets, r.made, r.there, r.seconds);
  if (r.retries > 0) text += fmt::format("{} times a worker failed and was tried again\n", r.retries);
  text += worker_time_text(r);
  for (const std::string& id : r.busy) text += id + ": another process is making it\n";
  for (const GivenUp& person : r.given_up) text += person.id + ": given up: " + person.reason + "\n";
  return text;
}

nlohmann::ordered_json to_json(const ProduceReport& r) {
  nlohmann::ordered_json json = {
      {"people", r.people},     {"sets", r.sets},       {"made", r.made},
      {"there", r.there},       {"retries", r.retries}, {"seconds", r.seconds},
      {"worker_s", r.worker_s}, {"busy", r.busy},       {"given_up", nlohmann::ordered_json::array()}};
  for (const GivenUp& person : r.given_up)
    json["given_up"].push_back({{"id", person.id}, {"reason", person.reason}});
  return json;
}

}  // namespace ohb::production
