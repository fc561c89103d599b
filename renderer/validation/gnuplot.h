// Runs gnuplot on a script.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ohb::validation {

/// A string literal of gnuplot: nothing in it is special but the quote, which is left out.
std::string gnuplot_quoted(std::string text);

/// Writes folder/chart.gp and draws it inside the folder. Throws InputError if gnuplot is missing or fails.
void run_gnuplot(const std::string& script, const std::filesystem::path& folder);

/// run_gnuplot on panels, each one `plot`, in rows of `columns`, as chart.svg and chart.png.
void draw_panels(const std::string& settings, const std::vector<std::string>& panels, size_t columns,
                 int width_px, size_t row_height_px, const std::filesystem::path& folder);

}  // namespace ohb::validation
