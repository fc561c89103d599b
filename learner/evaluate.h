// The paper's tables on people that the networks have not seen, beside rows that need no network.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "learner/measures.h"
#include "learner/metrics.h"
#include "learner/relit_scores.h"

namespace ohb::learner {

struct EvaluateOptions {
  std::vector<std::filesystem::path>
      weights;  // files or runs: priors, one or more; with all, finetune or not
  std::filesystem::path data;
  std::vector<std::string> people;     // empty: those held out, and not trained on by any of the networks
  int size_px = 0;                     // 0: as trained
  torch::Device device = torch::kCPU;  // of the networks
  RelitOptions relit;
  bool quiet = false;
};

/// A mean of pictures; NaN where there is no value.
struct Marks {
  Scores psnr;
  Measures measures;
};

struct EvaluationRow {
  std::string name;
  std::map<std::string, Marks> people;                // mean over the pictures of each person
  Marks mean;                                         // mean over people
  std::array<double, kColumns.size()> deviation_dB;   // of the masked values between people
  std::array<Interval, kColumns.size()> interval_dB;  // of the mean of the masked values
  std::array<Interval, kMeasureCount> interval;       // of the mean of the measures
};

/// The estimate's marks of some of the pictures.
struct PartOfPictures {
  std::string name;
  size_t count = 0;  // of people, or of pictures under a light
  Marks mean;
};

struct EvaluationReport {
  std::vector<EvaluationRow> rows;  // finetuned, priors or joint, constant, input as albedo, 8-bit round trip
  std::vector<PartOfPictures> groups, lights;  // of the first row
  std::vector<std::string> networks;           // task, width, and steps of each, in words
  std::vector<std::string> people;
  std::map<std::string, std::vector<std::string>> trained_on;  // of these people: the networks that knew them
  size_t pictures = 0;
  int size_px = 0;
  double seconds_a_picture = 0;  // of the networks
  std::optional<RelitReport> relit;
};

/// Every view of the people under every light. PSNR is taken of each picture and averaged (not of pooled
/// errors, which would give other numbers).
///
/// Reference rows: "constant" puts the mean of the training people's foreground everywhere (of the evaluated
/// people's where no training view is in the data); "input as albedo" takes the input for the albedo, "8-bit
/// truth" is the truth after 8-bit storage.
/// Relighting: RelitScores of relit_views, for all rows but "input as albedo".
/// Columns of a prior that is not given are NaN, and nothing is relit. People whom one of the networks was
/// trained on are evaluated only if they are named, and marked in the report. Throws InputError: weights or
/// data as load_network and read_example; nobody of these names; nobody but those trained on; environments as
/// RelitScores; a sample without its camera, if it is relit.
EvaluationReport evaluate(const EvaluateOptions& options);

/// People by the words of their names (digits left out, words that the same people have joined): those of
/// "p0003_m30_black" are "p", "m" and "black". Groups of one and of all are left out. Sorted by name.
std::map<std::string, std::vector<std::string>> groups_of(const std::vector<std::string>& people);

/// Tables, one row a line: PSNR masked and full frame, the measures, both by group and by light, relighting.
/// For the terminal and for a Markdown file.
std::string table_of(const EvaluationReport& report);
nlohmann::json json_of(const EvaluationReport& report);

}  // namespace ohb::learner
