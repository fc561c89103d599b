#include "renderer/validation/gnuplot.h"

#include <algorithm>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/process.h"

namespace ohb {
namespace fs = std::filesystem;

std::string gnuplot_quoted(std::string text) {
  text.erase(std::remove(text.begin(), text.end(), '\''), text.end());
  return "'" + text + "'";
}

void run_gnuplot(const std::string& script, const fs::path& folder) {
  write_file_atomically(folder / "chart.gp", script);
  // gnuplot goes to the folder first, so the script's own path must not depend on where we are.
  const fs::path there = fs::absolute(folder);
  const ProcessResult result =
      run_process({"gnuplot", "-e", "cd " + gnuplot_quoted(there.string()), (there / "chart.gp").string()},
                  {}, [](const std::string&) {});
  if (result.exit_code == 0) return;
  std::string message = "no message";
  for (const std::string& line : result.last_lines)
    if (line.find_first_not_of(" ^\t") != std::string::npos) message = line;
  throw InputError("gnuplot", "chart.gp", "failed: " + message, "install gnuplot-nox 5.4 or later");
}

}  // namespace ohb
