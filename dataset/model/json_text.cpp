#include "dataset/model/json_text.h"

#include <algorithm>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"

namespace ohb {
namespace {

/// "line 12" of the byte at which the parser stopped, which it counts from 1.
std::string line_at(std::string_view text, size_t byte) {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(byte, text.size()));
  return "line " + std::to_string(1 + std::count(text.begin(), end, '\n'));
}

}  // namespace

template <class Json>
Json parse_json(std::string_view text, const std::string& name, const JsonLimits& limits) {
  size_t values = 0;
  const auto within_limits = [&](int depth, typename Json::parse_event_t event, Json&) {
    using Event = typename Json::parse_event_t;
    const bool is_container = event == Event::object_start || event == Event::array_start;
    if (is_container && depth >= limits.depth)  // levels around it
      throw InputError(name, "JSON", "is nested deeper than " + std::to_string(limits.depth) + " levels",
                       "it is damaged, or no file for this program");
    if ((is_container || event == Event::value) && ++values > limits.values)
      throw InputError(name, "JSON", "holds more than " + std::to_string(limits.values) + " values",
                       "it is damaged, or no file for this program");
    return true;
  };
  try {
    return Json::parse(text.begin(), text.end(), within_limits);
  } catch (const typename Json::parse_error& error) {
    throw InputError(name, line_at(text, error.byte),
                     "is not well-formed JSON (byte " + std::to_string(error.byte) + " of the text)",
                     "correct it, or make it again");
  } catch (const typename Json::exception&) {
    throw InputError(name, "JSON", "holds a number that is too large", "correct it, or make it again");
  }
}

template nlohmann::json parse_json(std::string_view, const std::string&, const JsonLimits&);
template nlohmann::ordered_json parse_json(std::string_view, const std::string&, const JsonLimits&);

nlohmann::json read_json(const std::filesystem::path& file, const JsonLimits& limits) {
  return parse_json<nlohmann::json>(read_file(file), file.string(), limits);
}

}  // namespace ohb
