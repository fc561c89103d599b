// The job array that makes a dataset, as Slurm knows it.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "dataset/production/layout.h"

namespace ohb::production {

/// The script and the record of a dataset's job array, and what its tasks print.
std::filesystem::path slurm_folder(const Layout& layout);

/// What `submit` writes down.
struct ArrayRecord {
  std::string job;
  int tasks = 0;
};
/// None if nothing was submitted. Throws InputError if the record is damaged.
std::optional<ArrayRecord> read_array_record(const Layout& layout);
void write_array_record(const Layout& layout, const ArrayRecord& record);

struct ArrayStatus {
  ArrayRecord record;
  bool is_known = false;  // Slurm answered
  int pending = 0, running = 0, done = 0;
  int over = 0;                // ended, and Slurm no longer knows how
  std::string pending_reason;  // Slurm's word for the first of them: "Resources"
  struct Failed {
    int task = 0;
    std::string state;  // "FAILED", "TIMEOUT", "CANCELLED", ...
  };
  std::vector<Failed> failed;
  bool is_active() const { return pending + running > 0; }
};

/// By squeue, and sacct for what that has forgotten; each gets 20 s. None if nothing was submitted.
std::optional<ArrayStatus> array_status(const Layout& layout);

std::string to_text(const ArrayStatus& status);
nlohmann::ordered_json to_json(const ArrayStatus& status);

struct CommandAnswer {
  int code = 0;                    // -1: it cannot be started, or took too long
  std::vector<std::string> lines;  // of stdout and stderr
};
/// Runs one of Slurm's commands; it is ended after so many seconds.
CommandAnswer ask_slurm(const std::vector<std::string>& command, double patience_s);

}  // namespace ohb::production
