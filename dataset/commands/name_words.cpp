#include "dataset/commands/name_words.h"

#include <sstream>

#include "dataset/commands/label_rules.h"

namespace ohb::commands {
namespace {

// No locale: names are bytes.
bool is_lower(unsigned char c) {
  return (c >= 'a' && c <= 'z') || c >= 0x80;
}
bool is_upper(unsigned char c) {
  return c >= 'A' && c <= 'Z';
}

bool is_word(const std::string& pattern, const std::string& word) {
  if (matches_glob(pattern, word)) return true;
  const auto without = [&](size_t n) { return word.substr(0, word.size() - n); };
  if (word.size() > 3 && word.back() == 's' && matches_glob(pattern, without(1))) return true;
  return word.size() > 4 && word.compare(word.size() - 2, 2, "es") == 0 && matches_glob(pattern, without(2));
}

bool follow_each_other(const std::vector<std::string>& patterns, const std::vector<std::string>& words) {
  for (size_t first = 0; first + patterns.size() <= words.size(); ++first) {
    size_t i = 0;
    while (i < patterns.size() && is_word(patterns[i], words[first + i])) ++i;
    if (i == patterns.size()) return true;
  }
  return false;
}

}  // namespace

std::vector<std::string> words_of_name(const std::string& name) {
  std::vector<std::string> words(1);
  for (size_t i = 0; i < name.size(); ++i) {
    const auto c = static_cast<unsigned char>(name[i]);
    const auto next = static_cast<unsigned char>(i + 1 < name.size() ? name[i + 1] : '_');
    const auto before = static_cast<unsigned char>(i > 0 ? name[i - 1] : '_');
    if (!is_lower(c) && !is_upper(c)) {
      if (!words.back().empty()) words.emplace_back();
      continue;
    }
    // aB begins a word, and so does the last capital of a row that small letters follow: HAIRBand.
    const bool begins = is_upper(c) && (is_lower(before) || (is_upper(before) && is_lower(next)));
    if (begins && !words.back().empty()) words.emplace_back();
    words.back() += static_cast<char>(is_upper(c) ? c - 'A' + 'a' : c);
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

std::string matching_word(const std::string& alternatives, const std::vector<std::string>& words) {
  std::stringstream stream(alternatives);
  for (std::string alternative; std::getline(stream, alternative, '|');) {
    std::stringstream parts(alternative);
    std::vector<std::string> patterns;
    for (std::string part; parts >> part;) patterns.push_back(part);
    if (!patterns.empty() && follow_each_other(patterns, words)) return alternative;
  }
  return "";
}

}  // namespace ohb::commands
