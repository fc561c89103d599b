#include "dataset/model/blender.h"

#include <cstdio>

#include "dataset/model/data_files.h"
#include "dataset/model/error.h"

namespace ohb {
namespace fs = std::filesystem;

namespace {

/// Starts the program with these arguments; it prints "Blender" and its version.
void ask(const std::vector<std::string>& arguments, const std::string& mend, Blender& blender) {
  const std::string name = blender.program.string();
  std::vector<std::string> all = {name};
  all.insert(all.end(), arguments.begin(), arguments.end());
  try {
    run_process(all, {}, [&](const std::string& line) {
      char version[32];
      if (blender.version.empty() && std::sscanf(line.c_str(), "Blender %31s", version) == 1)
        blender.version = version;
    });
  } catch (const InputError&) {
    throw InputError(name, "", "Blender was not found there", mend);
  }
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

std::string reason_of(const std::vector<std::string>& lines) {
  for (auto line = lines.rbegin(); line != lines.rend(); ++line)
    if (line->find("rror: ") != std::string::npos && line->find("script failed") == std::string::npos)
      return *line;
  return lines.empty() ? "no output" : lines.back();
}

}  // namespace ohb
