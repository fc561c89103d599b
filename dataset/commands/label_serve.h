// Labelling as a conversation: JSON lines in, one JSON line out for each, for tools that paint on a scan.
//
// First line out, when the scan is read:
//   {"ready": true, "faces": 100104, "unit_cm": 100, "classes": ["skin", ...], <state>}
// Requests; "id" may be anything and comes back:
//   {"id": 1, "do": "stroke", "class": "leather", "radius_cm": 1.5, "points": [[face, x, y, z], ...]}
//   {"id": 2, "do": "undo"}                          takes back the last stroke
//   {"id": 3, "do": "strokes", "strokes": [{"class", "radius_cm", "points"}, ...]}   these instead of all so
//   far
//   {"id": 4, "do": "mesh", "folder": "/tmp/x"}      the scan as it was read: see scan_hand_over.h
//   {"id": 5, "do": "save", "file": "strokes.xml"}   writes the strokes, for label --strokes
//   {"id": 6, "do": "quit"}                          as the end of input does
// Answers: {"id": 1, <state>, "seconds": 0.2}, or {"id": 1, "error": "what is wrong; mend"}, after which all
// is as before. <state> is
//   "strokes": how many there are, "changed": [[first face, count, class], ...] since the answer before (at
//   first: all), "confidence": [[first face, count, 0 to 15], ...] likewise, "suggested": null or {"face",
//   "at": [x, y, z], "now", "rival", "area_cm2"}, "warnings": [...]
// Positions are in the scan's own unit and axes.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>

namespace ohb::commands {

struct LabelServeJob {
  std::filesystem::path scan;
  std::filesystem::path strokes;  // to start with; empty: none
  std::string unit;               // as --unit; empty: guessed
  std::string up = {};            // as --up: positions are in the turned axes
};

/// Longest line of a request; longer ones are read over and refused.
constexpr size_t kMaxRequest_bytes = 16 << 20;

/// Answers until the input ends or says quit. Throws InputError for a scan, unit or strokes that are wrong;
/// wrong requests are answered.
void serve_labels(const LabelServeJob& job, std::istream& in, std::ostream& out);

}  // namespace ohb::commands
