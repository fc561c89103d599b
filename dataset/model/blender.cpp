#include "dataset/model/blender.h"

#include <algorithm>
#include <cstdio>

#include "dataset/model/data_files.h"
#include "dataset/model/error.h"

namespace ohb {
namespace fs = std::filesystem;

namespace {

bool is_of_memory(const ProcessResult& result) {
  const auto& lines = result.last_lines;
  return result.exit_code > 128 || std::any_of(lines.begin(), lines.end(), speaks_of_memory);
}

/// Starts the program with these arguments; it prints "Blender" and its version.
void ask(const std::vector<std::string>& arguments, const std::string& mend, Blender& blender) {
  const std::string name = blender.program.string();
  std::vector<std::string> all = {name};
  all.insert(all.end(), arguments.begin(), arguments.end());
  ProcessResult result;
  try {
    result = run_process(all, {}, [&](const std::string& line) {
      char version[32];
      if (blender.version.empty() && std::sscanf(line.c_str(), "Blender %31s", version) == 1)
        blender.version = version;
    });
  } catch (const InputError&) {
    throw InputError(name, "", "Blender was not found there", mend);
  }
  // Ended by a signal, or its libraries could not be loaded: that is no other program.
  if (blender.version.empty() && result.exit_code != 0 && is_of_memory(result))
    throw_blender_failure(blender, result);
  if (std::sscanf(blender.version.c_str(), "%d.%d", &blender.major, &blender.minor) != 2)
    throw InputError(name, "", "does not answer as Blender does", mend);
}

}  // namespace

Blender ask_blender(const fs::path& program, const std::string& mend) {
  Blender blender;
  blender.program = program.empty() ? fs::path("blender") : program;
  ask({"--version"}, mend, blender);
  return blender;
}

Blender ask_bpy(const fs::path& environment, const std::string& mend) {
  Blender blender;
  blender.program = environment / "bin/python";
  blender.is_module = true;
  ask({"-c", "import bpy, os; print('Blender', bpy.app.version_string, flush=True); os._exit(0)"}, mend,
      blender);
  return blender;
}

ProcessResult run_in_blender(const Blender& blender, const fs::path& script,
                             const std::vector<std::string>& arguments, int threads, const fs::path& scratch,
                             const std::function<void(const std::string&)>& on_line) {
  const std::string name = blender.program.string(), file = program_file(script).string();
  std::vector<std::string> all = {name, file, "--"};
  if (!blender.is_module)
    all = {name,
           "-b",
           "-noaudio",
           "--factory-startup",
           "-t",
           std::to_string(threads),
           "--python-exit-code",
           "1",
           "--python",
           file,
           "--"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  const std::string inside = fs::absolute(scratch).string();
  return run_process(
      all, {{"TMPDIR", inside}, {"BLENDER_USER_CONFIG", inside}, {"BLENDER_USER_SCRIPTS", inside}}, on_line);
}

void throw_blender_failure(const Blender& blender, const ProcessResult& result) {
  const std::string program = blender.program.string(), reason = reason_of(result.last_lines);
  const std::string mend = "run the command again, with a smaller --size if memory was short";
  if (result.exit_code > 128)
    throw TryAgainError(program, "was ended by signal " + std::to_string(result.exit_code - 128), mend);
  const std::string words = "stopped with code " + std::to_string(result.exit_code) + " (" + reason + ")";
  if (is_of_memory(result)) throw TryAgainError(program, words, mend);
  throw InputError(program, "", words, "check that it renders by itself");
}

std::string reason_of(const std::vector<std::string>& lines) {
  for (auto line = lines.rbegin(); line != lines.rend(); ++line)
    if (line->find("rror: ") != std::string::npos && line->find("script failed") == std::string::npos)
      return *line;
  return lines.empty() ? "no output" : lines.back();
}

}  // namespace ohb
