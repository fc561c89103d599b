// Answers to the questions of labelling: "trousers=leather" becomes a stroke on the trousers.
#pragma once

#include <string>
#include <vector>

#include "dataset/labelling/labeller.h"

namespace ohb::commands {

/// One stroke each, later than `after_s`. The name is a question's, or its number in the report without any
/// answer (from 1). Throws InputError: not NAME=CLASS, no such garment, one garment answered twice.
std::vector<labelling::Stroke> strokes_of_answers(const std::vector<std::string>& answers,
                                                  labelling::Labeller& labeller, double after_s);

/// The element of strokes.xml that answers a question so.
std::string stroke_line(const labelling::Stroke& stroke);

}  // namespace ohb::commands
