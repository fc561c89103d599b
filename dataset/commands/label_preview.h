// Pictures of a labelled person for people: front and back, the class of each face in its colour, what is
// asked about hatched, with a legend.
#pragma once

#include <filesystem>

#include "dataset/commands/label_report.h"

namespace ohb::commands {

/// Writes preview_front.png, preview_back.png (orthographic, +Y up, seen along -Z and +Z) and preview.svg,
/// which shows both with the legend and the questions. `question_of_face`: index into the report's questions,
/// or any larger number; empty: none.
void write_previews(const std::filesystem::path& folder, const Scan& scan,
                    const std::vector<uint8_t>& face_class, const std::vector<uint32_t>& question_of_face,
                    const LabelReport& report);

}  // namespace ohb::commands
