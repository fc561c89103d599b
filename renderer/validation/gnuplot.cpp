#include "renderer/validation/gnuplot.h"

#include <fmt/format.h>

#include <algorithm>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/image_damage.h"
#include "dataset/model/process.h"

namespace ohb::validation {
namespace fs = std::filesystem;

std::string gnuplot_quoted(std::string text) {
  text.erase(std::remove(text.begin(), text.end(), '\''), text.end());
  return "'" + text + "'";
}

namespace {

/// gnuplot says nothing of a disk that is full.
void check_charts(const fs::path& folder) {
  for (const char* name : {"chart.svg", "chart.png"}) {
    const fs::path file = folder / name;
    if (!fs::exists(file)) continue;
    const std::string bytes = read_file(file);
    const bool is_whole = file.extension() == ".png" ? !bytes.empty() && png_damage(bytes).empty()
                                                     : bytes.rfind("</svg>") != std::string::npos;
    if (!is_whole)
      throw TryAgainError(file.string(), "gnuplot did not write it whole",
                          "free some space and run the command again");
  }
}

}  // namespace

void run_gnuplot(const std::string& script, const fs::path& folder) {
  write_file_atomically(folder / "chart.gp", script);
  // gnuplot goes to the folder first, so the script's own path must not depend on where we are.
  const fs::path there = fs::absolute(folder);
  const ProcessResult result =
      run_process({"gnuplot", "-e", "cd " + gnuplot_quoted(there.string()), (there / "chart.gp").string()},
                  {}, [](const std::string&) {});
  if (result.exit_code == 0) {
    check_charts(folder);
    return;
  }
  std::string message = "no message";
  for (const std::string& line : result.last_lines)
    if (line.find_first_not_of(" ^\t") != std::string::npos) message = line;
  throw InputError("gnuplot", "chart.gp", "failed: " + message, "install gnuplot-nox 5.4 or later");
}

void draw_panels(const std::string& settings, const std::vector<std::string>& panels, size_t columns,
                 int width_px, size_t row_height_px, const fs::path& folder) {
  const size_t rows = (panels.size() + columns - 1) / columns, height_px = rows * row_height_px;
  const std::string layout =
      fmt::format("set multiplot layout {},{}\n{}unset multiplot\n", rows, columns, fmt::join(panels, ""));
  std::string script = settings;
  script += fmt::format("set terminal svg size {},{} background rgb 'white'\nset output 'chart.svg'\n",
                        width_px, height_px) +
            layout;
  script +=
      fmt::format("set terminal pngcairo size {},{}\nset output 'chart.png'\n", width_px, height_px) + layout;
  run_gnuplot(script, folder);
}

}  // namespace ohb::validation
