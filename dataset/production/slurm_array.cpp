#include "dataset/production/slurm_array.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"
#include "dataset/model/process.h"
#include "dataset/model/stopwatch.h"

namespace ohb::production {
namespace fs = std::filesystem;
namespace {

constexpr double kPatience_s = 20;
constexpr int kSchema = 1;

const std::set<std::string> kPending = {"PENDING",      "REQUEUED",    "REQUEUE_FED", "REQUEUE_HOLD",
                                        "SPECIAL_EXIT", "CONFIGURING", "SUSPENDED",   "RESV_DEL_HOLD"};
const std::set<std::string> kRunning = {"RUNNING",  "COMPLETING", "SIGNALING",
                                        "RESIZING", "STAGE_OUT",  "STOPPED"};

struct TaskState {
  std::string state, reason;
};

/// Words of a line between bars.
std::vector<std::string> fields(const std::string& line) {
  std::vector<std::string> found(1);
  for (const char c : line)
    if (c == '|')
      found.emplace_back();
    else
      found.back() += c;
  return found;
}

void add_task(const std::string& number, TaskState state, std::map<int, TaskState>& tasks) {
  int task = 0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), task);
  if (error != std::errc() || end != number.data() + number.size()) return;
  state.state.erase(std::min(state.state.size(), state.state.find(' ')));  // "CANCELLED by 1000"
  tasks.emplace(task, std::move(state));
}

/// False if Slurm does not answer at all.
bool ask_for_tasks(const std::string& job, std::map<int, TaskState>& tasks) {
  const CommandAnswer queue =
      ask_slurm({"squeue", "-h", "-r", "-t", "all", "-j", job, "-o", "%K|%T|%r"}, kPatience_s);
  // A number that Slurm has forgotten is an answer.
  const bool is_forgotten = std::any_of(queue.lines.begin(), queue.lines.end(), [](const std::string& line) {
    return line.find("Invalid job id") != std::string::npos;
  });
  if (queue.code != 0 && !is_forgotten) return false;
  for (const std::string& line : queue.lines)
    if (const std::vector<std::string> words = fields(line); words.size() == 3)
      add_task(words[0], {words[1], words[2]}, tasks);
  return true;
}

/// Fails in silence where no accounting is kept.
void ask_for_ended_tasks(const std::string& job, std::map<int, TaskState>& tasks) {
  for (const std::string& line :
       ask_slurm({"sacct", "-n", "-P", "-X", "-j", job, "-o", "JobID,State"}, kPatience_s).lines)
    if (const std::vector<std::string> words = fields(line);
        words.size() == 2 && words[0].rfind(job + "_", 0) == 0)
      add_task(words[0].substr(job.size() + 1), {words[1], ""}, tasks);
}

fs::path record_file(const Layout& layout) {
  return slurm_folder(layout) / "array.json";
}

}  // namespace

fs::path slurm_folder(const Layout& layout) {
  return layout.state() / "slurm";
}

CommandAnswer ask_slurm(const std::vector<std::string>& command, double patience_s) {
  struct TooLong {};
  CommandAnswer answer;
  const Stopwatch watch;
  try {
    answer.code = run_process(
                      command, {}, [&](const std::string& line) { answer.lines.push_back(line); },
                      [&] {
                        if (watch.wall_s() > patience_s) throw TooLong();
                      })
                      .exit_code;
  } catch (const InputError&) {
    answer.code = -1;
  } catch (const TooLong&) {
    answer.code = -1;
    answer.lines.push_back(fmt::format("no answer in {:g} s", patience_s));
  }
  return answer;
}

std::optional<ArrayRecord> read_array_record(const Layout& layout) {
  const fs::path file = record_file(layout);
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return std::nullopt;
  try {
    const nlohmann::json json = read_json(file);
    ArrayRecord record{json.at("job").get<std::string>(), json.at("tasks").get<int>()};
    const bool is_number =
        !record.job.empty() && record.job.find_first_not_of("0123456789") == std::string::npos;
    if (is_number && record.tasks >= 1) return record;
  } catch (const nlohmann::json::exception&) {
  }
  throw InputError(file.string(), "", "is damaged", "remove it; the dataset does not need it");
}

void write_array_record(const Layout& layout, const ArrayRecord& record) {
  make_folders(slurm_folder(layout));
  const nlohmann::ordered_json json = {{"schema", kSchema}, {"job", record.job}, {"tasks", record.tasks}};
  write_file_atomically(record_file(layout), json_text(json, 1) + "\n");
}

std::optional<ArrayStatus> array_status(const Layout& layout) {
  const std::optional<ArrayRecord> record = read_array_record(layout);
  if (!record) return std::nullopt;
  ArrayStatus status;
  status.record = *record;
  std::map<int, TaskState> tasks;
  status.is_known = ask_for_tasks(record->job, tasks);
  if (!status.is_known) return status;
  if (tasks.size() < static_cast<size_t>(record->tasks)) ask_for_ended_tasks(record->job, tasks);
  for (int task = 1; task <= record->tasks; ++task) {
    const auto found = tasks.find(task);
    if (found == tasks.end()) {
      ++status.over;
      continue;
    }
    const TaskState& is = found->second;
    if (kPending.count(is.state)) {
      if (status.pending++ == 0) status.pending_reason = is.reason;
    } else if (kRunning.count(is.state)) {
      ++status.running;
    } else if (is.state == "COMPLETED") {
      ++status.done;
    } else {
      status.failed.push_back({task, is.state});
    }
  }
  return status;
}

std::string to_text(const ArrayStatus& s) {
  std::string text = fmt::format("array {} of {} tasks: ", s.record.job, s.record.tasks);
  if (!s.is_known) return text + "Slurm does not answer here (squeue)\n";
  text +=
      fmt::format("{} pending{}, {} running, {} done", s.pending,
                  s.pending_reason.empty() || s.pending_reason == "None" ? "" : " (" + s.pending_reason + ")",
                  s.running, s.done);
  if (!s.failed.empty()) text += fmt::format(", {} failed", s.failed.size());
  if (s.over > 0) text += fmt::format(", {} over (Slurm no longer knows how)", s.over);
  text += "\n";
  for (const ArrayStatus::Failed& task : s.failed)
    text += fmt::format("task {}: {}: .ohb/slurm/logs/{}_{}.txt\n", task.task, task.state, s.record.job,
                        task.task);
  return text;
}

nlohmann::ordered_json to_json(const ArrayStatus& s) {
  nlohmann::ordered_json json = {{"job", s.record.job}, {"tasks", s.record.tasks}, {"known", s.is_known}};
  if (!s.is_known) return json;
  json.update({{"pending", s.pending}, {"running", s.running}, {"done", s.done}, {"over", s.over}});
  json["failed"] = nlohmann::ordered_json::array();
  for (const ArrayStatus::Failed& task : s.failed)
    json["failed"].push_back({{"task", task.task}, {"state", task.state}});
  return json;
}

}  // namespace ohb::production
