#include "dataset/production/slurm.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"
#include "dataset/model/temporary.h"
#include "dataset/production/claim.h"
#include "dataset/production/slurm_array.h"

namespace ohb::production {
namespace fs = std::filesystem;
namespace {

constexpr double kPatience_s = 120;    // of a busy cluster, for a submission
constexpr int kUsualArraySize = 1001;  // MaxArraySize where nothing else is set
constexpr int kMostShards = 9999;      // of `produce`
constexpr int kWarning_s = 120, kShortest_s = 600;
constexpr int kMostRestarts = 50;

/// A word of bash.
std::string quoted(const std::string& text) {
  std::string word = "'";
  for (const char c : text)
    if (c == '\'')
      word += "'\\''";
    else
      word += c;
  return word + "'";
}

/// The paths are absolute, for a task starts in the dataset's folder. The text of a #SBATCH line is read by
/// Slurm, which knows other quotes than bash: only plain words get there (check_options).
constexpr const char* kScript = R"script(#!/bin/bash
# Written by `openhumanbrdf submit`: task i of {tasks} makes the i-th part of the people. It may be killed and queued
# again at any moment; what is finished is kept. By hand: cd to the dataset's folder, sbatch .ohb/slurm/job.sh
#SBATCH --job-name=openhumanbrdf
#SBATCH --array=1-{tasks}{at_once}
#SBATCH --ntasks=1
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --signal=B:TERM@{warning}
#SBATCH --output=.ohb/slurm/logs/%A_%a.txt
{options}
program={program}
plan={plan}
dataset={dataset}
task="$SLURM_ARRAY_JOB_ID"_"$SLURM_ARRAY_TASK_ID"

# Beside this shell, which could not hear the warning before the time limit while it waits for a command.
stopped=
trap 'stopped=yes; kill -TERM "$work"' TERM
"$program" produce "$plan" -o "$dataset" --shard "$SLURM_ARRAY_TASK_ID/{tasks}" \
  --threads "${{SLURM_CPUS_PER_TASK:-${{SLURM_CPUS_ON_NODE:-1}}}}" &
work=$!
wait "$work"
code=$?
if [ -n "$stopped" ]; then
  wait "$work"
  code=$?
fi
# 75: try again (time is up, disk full). Not if somebody cancelled it, and not for ever.
if [ "$code" -eq 75 ] && [ "${{SLURM_RESTART_COUNT:-0}}" -lt {restarts} ] &&
  [ "$(squeue -h -j "$task" -o %T)" = RUNNING ]; then
  scontrol requeue "$task"
fi
exit "$code"
)script";

/// Seconds of Slurm's ways to write a time. Throws InputError.
long seconds_of(const std::string& time) {
  static const std::map<std::string, std::vector<long>> kForms = {{"", {60}},
                                                                  {":", {60, 1}},
                                                                  {"::", {3600, 60, 1}},
                                                                  {"-", {86400, 3600}},
                                                                  {"-:", {86400, 3600, 60}},
                                                                  {"-::", {86400, 3600, 60, 1}}};
  std::vector<long> numbers(1);
  std::string signs;
  for (const char c : time)
    if (c >= '0' && c <= '9') {
      numbers.back() = 10 * numbers.back() + (c - '0');
    } else {
      signs += c;
      numbers.emplace_back();
    }
  const auto form = kForms.find(signs);
  constexpr size_t kLongest = 15;  // no number of so few digits runs over
  if (form == kForms.end() || time.size() > kLongest ||
      !std::isdigit(static_cast<unsigned char>(time.front())) ||
      !std::isdigit(static_cast<unsigned char>(time.back())))
    throw InputError("", "--time " + time, "is no time limit of Slurm's",
                     "write minutes, hours:minutes:seconds or days-hours, for example 12:00:00");
  long seconds = 0;
  for (size_t i = 0; i < numbers.size(); ++i) seconds += form->second[i] * numbers[i];
  return seconds;
}

/// The array's own lines; another one would undo them.
const std::set<std::string> kOurs = {"array",     "requeue",      "no-requeue", "open-mode", "signal",
                                     "output",    "error",        "ntasks",     "chdir",     "wrap",
                                     "input",     "job-name",     "parsable",   "test-only", "time",
                                     "partition", "cpus-per-task"};

constexpr const char* kLower = "abcdefghijklmnopqrstuvwxyz";
constexpr const char* kNames = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_.,-";
constexpr const char* kValues =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_.,:;@%+/&|*()=[]-";

bool is_made_of(const std::string& text, const char* signs) {
  return !text.empty() && text.find_first_not_of(signs) == std::string::npos;
}

/// "account=lab" or "exclusive".
bool is_option(const std::string& option) {
  const size_t equals = option.find('=');
  const std::string name = option.substr(0, equals);
  return is_made_of(name, "abcdefghijklmnopqrstuvwxyz0123456789-") && is_made_of(name.substr(0, 1), kLower) &&
         (equals == std::string::npos || is_made_of(option.substr(equals + 1), kValues));
}

/// Throws InputError.
void check_options(const SubmitJob& job) {
  if (!job.time.empty() && seconds_of(job.time) < kShortest_s)
    throw InputError("", "--time " + job.time, "is less than 10 minutes",
                     "give a task the time for some sets at least: it is stopped 2 minutes before");
  if (!job.partition.empty() && (!is_made_of(job.partition, kNames) || job.partition[0] == '-'))
    throw InputError("", "--partition " + job.partition, "is no partition's name", "`sinfo` lists them");
  for (const std::string& option : job.sbatch) {
    if (!is_option(option))
      throw InputError("", "--sbatch " + option,
                       "is no option of sbatch, or has signs that its script cannot hold",
                       "write it as account=lab, without leading dashes");
    if (kOurs.count(option.substr(0, option.find('='))))
      throw InputError("", "--sbatch " + option, "is set by `submit` itself",
                       "see --help for what can be set");
  }
}

/// The most tasks of one array: MaxArraySize is one more.
int most_tasks() {
  int size = kUsualArraySize;
  for (const std::string& line : ask_slurm({"scontrol", "show", "config"}, kPatience_s).lines)
    if (line.rfind("MaxArraySize", 0) == 0)
      size = std::atoi(line.c_str() + std::min(line.size(), line.find_first_of("0123456789")));
  return std::clamp(size - 1, 1, kMostShards);
}

int task_count(const SubmitJob& job) {
  const int most = most_tasks(),
            people = static_cast<int>(std::min<size_t>(job.plan.people.size(), kMostShards));
  if (job.tasks > most)
    throw InputError("", fmt::format("--tasks {}", job.tasks),
                     fmt::format("this cluster takes {} in one array", most),
                     "give fewer: a task makes its people one after the other");
  return std::min(job.tasks > 0 ? job.tasks : most, people);
}

std::string option_lines(const SubmitJob& job) {
  std::string lines;
  if (!job.time.empty()) lines += "#SBATCH --time=" + job.time + "\n";
  if (!job.partition.empty()) lines += "#SBATCH --partition=" + job.partition + "\n";
  if (job.threads > 0) lines += fmt::format("#SBATCH --cpus-per-task={}\n", job.threads);
  for (const std::string& option : job.sbatch) lines += "#SBATCH --" + option + "\n";
  return lines;
}

fs::path whole_path(const fs::path& path) {
  std::error_code error;
  const fs::path whole = fs::absolute(path, error);
  if (error)
    throw InputError(path.string(), "", "cannot be found from here: " + error.message(), "check the path");
  return whole.lexically_normal();
}

/// Runs sbatch and gives the line with the number, if it prints one. Throws InputError or TryAgainError in
/// its words.
std::string sbatch(const std::vector<std::string>& options, const fs::path& dataset, const fs::path& script) {
  std::vector<std::string> command = {"sbatch", "--chdir=" + dataset.string()};
  command.insert(command.end(), options.begin(), options.end());
  command.push_back(script.string());
  const CommandAnswer answer = ask_slurm(command, kPatience_s);
  if (answer.code == -1 && answer.lines.empty())
    throw InputError("sbatch", "", "cannot be started",
                     "run this where Slurm's commands are, or run `produce --shard i/n` in your own way");
  std::string words;
  for (const std::string& line : answer.lines)
    // Sites add lines of their own; the array's number, "12" or "12;cluster", is the one that is wanted.
    if (!line.empty() && (answer.code != 0 || std::isdigit(static_cast<unsigned char>(line[0]))))
      words = line;
  if (answer.code == 0) return words;
  for (const char* sign : {"ontact slurm", "ommunication connection", "imed out", "no answer", "emporarily",
                           "unge", "rotocol authentication", "Zero Bytes"})
    if (words.find(sign) != std::string::npos)
      throw TryAgainError("sbatch", "the cluster does not answer: " + words, "run the command again later");
  throw InputError("sbatch", "", "refuses: " + words, "correct the options, or ask who runs the cluster");
}

/// Refuses while tasks of an earlier array are waiting or at work.
void expect_no_array(const Layout& layout) {
  const std::optional<ArrayStatus> array = array_status(layout);
  if (array && array->is_active())
    throw TryAgainError(layout.root.string(), "array " + array->record.job + " is not over",
                        "wait for it (`openhumanbrdf status`), or end it: scancel " + array->record.job);
}

}  // namespace

SubmitReport prepare(const SubmitJob& job) {
  check_options(job);
  const std::string dataset = whole_path(job.output).string();
  if (dataset.find_first_of("%\\\n\r") != std::string::npos)
    throw InputError(dataset, "",
                     "has a sign in its path that Slurm takes for something else (% \\ line break)",
                     "give a path without it, by way of a link if need be");
  SubmitReport report;
  report.people = job.plan.people.size();
  report.tasks = task_count(job);
  std::error_code ignored;
  report.script =
      fmt::format(kScript, fmt::arg("tasks", report.tasks),
                  fmt::arg("at_once", job.at_once > 0 ? fmt::format("%{}", job.at_once) : ""),
                  fmt::arg("warning", kWarning_s), fmt::arg("options", option_lines(job)),
                  fmt::arg("program", quoted(fs::read_symlink("/proc/self/exe", ignored).string())),
                  fmt::arg("plan", quoted(whole_path(job.plan.file).string())),
                  fmt::arg("dataset", quoted(dataset)), fmt::arg("restarts", kMostRestarts));
  return report;
}

SubmitReport submit(const SubmitJob& job) {
  SubmitReport report = prepare(job);
  const Layout layout{whole_path(job.output)};
  expect_no_array(layout);
  // Whether it would be taken, before anything is written to the dataset's folder.
  const LockedTemporary folder(fs::temp_directory_path() / "openhumanbrdf_submit",
                               LockedTemporary::Kind::kFolder);
  const fs::path trial = folder.path() / "job.sh";
  write_file_atomically(trial, report.script);
  sbatch({"--test-only"}, layout.root, trial);
  claim_folder(layout.root, "dataset");
  const auto lock = lock_plan(job.plan, layout);
  make_folders(slurm_folder(layout) / "logs");
  write_file_atomically(slurm_folder(layout) / "job.sh", report.script);
  const std::string answer = sbatch({"--parsable"}, layout.root, slurm_folder(layout) / "job.sh");
  report.job = answer.substr(0, answer.find_first_not_of("0123456789"));
  write_array_record(layout, {report.job, report.tasks});
  return report;
}

std::string to_text(const SubmitReport& r, const fs::path& output) {
  if (r.job.empty()) return r.script;
  return fmt::format("array {} queued: {} tasks for {} people\nhow far it is: openhumanbrdf status {}\n",
                     r.job, r.tasks, r.people, quoted(output.string()));
}

nlohmann::ordered_json to_json(const SubmitReport& r) {
  nlohmann::ordered_json json = {{"tasks", r.tasks}, {"people", r.people}, {"script", r.script}};
  if (!r.job.empty()) json["job"] = r.job;
  return json;
}

}  // namespace ohb::production
