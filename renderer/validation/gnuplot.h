// Runs gnuplot on a script.
#pragma once

#include <filesystem>
#include <string>

namespace ohb {

/// A string literal of gnuplot: nothing in it is special but the quote, which is left out.
std::string gnuplot_quoted(std::string text);

/// Writes folder/chart.gp and draws it inside the folder. Throws InputError if gnuplot is missing or fails.
void run_gnuplot(const std::string& script, const std::filesystem::path& folder);

}  // namespace ohb
