// The tables and the JSON of an evaluation.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "learner/evaluate.h"

namespace ohb::learner {
namespace {

using nlohmann::json;

constexpr size_t kNameWidth = 18;

/// "| name | ... |" and the line below it.
std::string head_of(const std::string& name, const std::vector<std::string>& columns) {
  std::string text = fmt::format("| {:<{}} |", name, kNameWidth),
              line = "|" + std::string(kNameWidth + 2, '-') + "|";
  for (const std::string& column : columns) {
    text += fmt::format(" {:>6} |", column);
    line += std::string(std::max<size_t>(6, column.size()) + 1, '-') + ":|";
  }
  return text + "\n" + line + "\n";
}

/// A line of numbers under `columns`.
std::string line_of(const std::string& name, const std::vector<double>& values,
                    const std::vector<std::string>& columns) {
  std::string text = fmt::format("| {:<{}} |", name, kNameWidth);
  for (size_t i = 0; i < values.size(); ++i) text += table_cell(values[i], columns[i].size());
  return text + "\n";
}

std::vector<std::string> psnr_columns() {
  std::vector<std::string> columns(kColumns.begin(), kColumns.end());
  columns.push_back("maps mean");
  return columns;
}

std::vector<double> psnr_values(const Scores& scores, double Psnr::*value) {
  std::vector<double> values;
  for (const Psnr& score : scores) values.push_back(score.*value);
  values.push_back(maps_mean(scores, value));
  return values;
}

/// The ends of the interval and the weakest person, for a row of an estimate.
template <typename Intervals, typename ValueOf>
std::string spread_lines(const EvaluationRow& row, const Intervals& intervals,
                         const std::vector<std::string>& columns, const ValueOf& value_of) {
  std::vector<double> low, high, weakest;
  for (size_t i = 0; i < intervals.size(); ++i) {
    low.push_back(intervals[i].low);
    high.push_back(intervals[i].high);
    double least = std::nan("");
    for (const auto& [person, marks] : row.people) {
      const auto [value, more_is_better] = value_of(marks, i);
      if (std::isnan(least) || (more_is_better ? value < least : value > least)) least = value;
    }
    weakest.push_back(least);
  }
  return line_of(row.name + ", 5 %", low, columns) + line_of(row.name + ", 95 %", high, columns) +
         line_of(row.name + ", weakest", weakest, columns);
}

bool is_estimate(const EvaluationRow& row) {
  return row.name == "finetuned" || row.name == "priors" || row.name == "joint";
}

std::string psnr_table(const EvaluationReport& report, double Psnr::*value, const std::string& title) {
  const std::vector<std::string> columns = psnr_columns();
  std::string text = title + "\n\n" + head_of("row", columns);
  for (const EvaluationRow& row : report.rows) {
    text += line_of(row.name, psnr_values(row.mean.psnr, value), columns);
    if (value == &Psnr::masked && is_estimate(row)) {
      const std::vector<std::string> without_mean(columns.begin(), columns.end() - 1);
      const auto padded = [&](const std::string& lines) {  // the column of means has no interval
        std::string out;
        for (size_t begin = 0, end; (end = lines.find('\n', begin)) != std::string::npos; begin = end + 1)
          out += lines.substr(begin, end - begin) + fmt::format(" {:>9} |\n", "");
        return out;
      };
      text += padded(spread_lines(row, row.interval_dB, without_mean, [](const Marks& marks, size_t i) {
        return std::pair(marks.psnr[i].masked, true);
      }));
    }
  }
  return text + "\n";
}

std::vector<std::string> measure_columns() {
  return {kMeasureNames.begin(), kMeasureNames.end()};
}

std::string measures_table(const EvaluationReport& report) {
  const std::vector<std::string> columns = measure_columns();
  std::string text =
      "Other measures over the foreground: angle between the normals, PSNR of the albedo after the one "
      "factor "
      "that fits best, its structural similarity, intersection over union of the materials\n\n" +
      head_of("row", columns);
  for (const EvaluationRow& row : report.rows) {
    text += line_of(row.name, {row.mean.measures.begin(), row.mean.measures.end()}, columns);
    if (is_estimate(row))
      text += spread_lines(row, row.interval, columns, [](const Marks& marks, size_t i) {
        return std::pair(marks.measures[i], kMoreIsBetter[i]);
      });
  }
  return text + "\n";
}

/// PSNR and measures of the estimate by group or by light.
std::string parts_table(const std::vector<PartOfPictures>& parts, const std::string& title,
                        const std::string& name, const std::string& counted) {
  if (parts.size() < 2) return "";
  std::vector<std::string> columns = {counted};
  columns.insert(columns.end(), kColumns.begin(), kColumns.end());
  for (const std::string& column : measure_columns()) columns.push_back(column);
  std::string text = title + "\n\n" + head_of(name, columns);
  for (const PartOfPictures& part : parts) {
    std::vector<double> values;
    for (const Psnr& score : part.mean.psnr) values.push_back(score.masked);
    values.insert(values.end(), part.mean.measures.begin(), part.mean.measures.end());
    text += fmt::format("| {:<{}} | {:>6} |", part.name, kNameWidth, part.count);
    for (size_t i = 0; i < values.size(); ++i) text += table_cell(values[i], columns[i + 1].size());
    text += "\n";
  }
  return text + "\n";
}

json marks_json(const Marks& marks) {
  json out;
  for (size_t i = 0; i < kColumns.size(); ++i)
    out[kColumns[i]] = {{"masked", json_number(marks.psnr[i].masked)},
                        {"full", json_number(marks.psnr[i].full)}};
  out["maps_mean"] = {{"masked", json_number(maps_mean(marks.psnr, &Psnr::masked))},
                      {"full", json_number(maps_mean(marks.psnr, &Psnr::full))}};
  for (size_t i = 0; i < kMeasureCount; ++i)
    out["measures"][kMeasureNames[i]] = json_number(marks.measures[i]);
  return out;
}

json interval_json(const Interval& interval) {
  return {json_number(interval.low), json_number(interval.high)};
}

json parts_json(const std::vector<PartOfPictures>& parts) {
  json out = json::array();
  for (const PartOfPictures& part : parts)
    out.push_back({{"name", part.name}, {"count", part.count}, {"mean", marks_json(part.mean)}});
  return out;
}

/// The words of a name without their digits.
std::set<std::string> words_in(const std::string& name) {
  std::set<std::string> words;
  std::string word;
  for (const char c : name + "_") {
    if (std::isalpha(static_cast<unsigned char>(c))) word += c;
    if (std::isalnum(static_cast<unsigned char>(c))) continue;
    if (!word.empty()) words.insert(word);
    word.clear();
  }
  return words;
}

}  // namespace

std::map<std::string, std::vector<std::string>> groups_of(const std::vector<std::string>& people) {
  std::map<std::string, std::vector<std::string>> members;  // of a word
  for (const std::string& person : people)
    for (const std::string& word : words_in(person)) members[word].push_back(person);
  std::map<std::vector<std::string>, std::string> names;
  for (const auto& [word, group] : members) {
    if (group.size() < 2 || group.size() == people.size()) continue;
    std::string& name = names[group];
    // Words that the same people have are one name, in the order in which they stand there.
    if (name.empty())
      name = word;
    else
      name = group.front().find(word) < group.front().find(name) ? fmt::format("{} {}", word, name)
                                                                 : fmt::format("{} {}", name, word);
  }
  std::map<std::string, std::vector<std::string>> groups;
  for (const auto& [group, name] : names) groups[name] = group;
  return groups;
}

std::string table_of(const EvaluationReport& report) {
  std::string text =
      fmt::format("{} pictures of {} people at {} x {}; networks: {}\n\n", report.pictures,
                  report.people.size(), report.size_px, report.size_px, fmt::join(report.networks, ", "));
  for (const auto& [name, by] : report.trained_on)
    text += fmt::format("TRAINED ON, not held out: {} (by {})\n\n", name, fmt::join(by, ", "));
  text +=
      psnr_table(report, &Psnr::masked,
                 "PSNR over the foreground, dB: mean over pictures, then over people; 5 % and 95 %: where "
                 "that mean lies for other people of this kind (bootstrap); weakest: of one person");
  text += psnr_table(report, &Psnr::full, "PSNR over the whole frame, dB");
  text += measures_table(report);
  const std::string estimate = report.rows.front().name;
  text += parts_table(report.groups, estimate + ", by group", "group", "people");
  text += parts_table(report.lights, estimate + ", by light: mean over its pictures", "light", "pictures");
  return text + (report.relit ? table_of(*report.relit) : "");
}

json json_of(const EvaluationReport& report) {
  json out = {{"people", report.people},
              {"trained_on", report.trained_on},
              {"networks", report.networks},
              {"pictures", report.pictures},
              {"size_px", report.size_px},
              {"seconds_a_picture", report.seconds_a_picture},
              {"groups", parts_json(report.groups)},
              {"lights", parts_json(report.lights)}};
  for (const EvaluationRow& row : report.rows) {
    json r = {{"name", row.name}, {"mean", marks_json(row.mean)}};
    for (size_t i = 0; i < kColumns.size(); ++i) {
      r["deviation_dB"][kColumns[i]] = json_number(row.deviation_dB[i]);
      r["interval"][kColumns[i]] = interval_json(row.interval_dB[i]);
    }
    for (size_t i = 0; i < kMeasureCount; ++i)
      r["interval"][kMeasureNames[i]] = interval_json(row.interval[i]);
    for (const auto& [person, marks] : row.people) r["people"][person] = marks_json(marks);
    out["rows"].push_back(r);
  }
  if (report.relit) out["relighting"] = json_of(*report.relit);
  return out;
}

}  // namespace ohb::learner
