// Finds Blender and runs our scripts in it, without a window.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "dataset/model/process.h"

namespace ohb {

struct Blender {
  std::filesystem::path program;  // or Python, where Blender is its module bpy
  std::string version;            // "3.4.1"
  int major = 0, minor = 0;       // 3, 4
  bool is_module = false;
};

/// Asks the program (empty: `blender` in PATH) for its version. Throws InputError, with `mend` in its words,
/// if it cannot be started or does not answer as Blender does.
Blender ask_blender(const std::filesystem::path& program, const std::string& mend);

/// The same for a Python virtual environment that has the module bpy.
Blender ask_bpy(const std::filesystem::path& environment, const std::string& mend);

/// Runs a script of ours (program_file) with factory settings and these arguments after "--". threads 0: all;
/// a module is not told: its scripts set them.
/// Temporary files and Blender's user settings go to `scratch`, an existing folder that the caller removes.
/// A script that fails before it chooses an exit code gives 1. Throws as run_process and program_file.
ProcessResult run_in_blender(const Blender& blender, const std::filesystem::path& script,
                             const std::vector<std::string>& arguments, int threads,
                             const std::filesystem::path& scratch,
                             const std::function<void(const std::string&)>& on_line);

/// Says why a run did not end with 0. Throws TryAgainError if a signal ended Blender or it found no memory,
/// else InputError.
[[noreturn]] void throw_blender_failure(const Blender& blender, const ProcessResult& result);

/// The last line of an output that says what went wrong: a Python exception or an error of Blender's.
std::string reason_of(const std::vector<std::string>& lines);

}  // namespace ohb
