// All JSON is read and written here: within limits, errors in words, and whatever bytes a name has.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace ohb {

/// What a text may hold: brackets within brackets (others' code and ours copies and prints values by
/// recursion), and values in all (each takes some twenty to a hundred times its bytes in memory).
struct JsonLimits {
  int depth = 64;
  size_t values = size_t{1} << 20;
};

/// Limits for lists that grow with the number of views.
constexpr JsonLimits kListingLimits{64, size_t{1} << 24};

/// Parses one JSON value. Throws InputError, "name: line 3: what is wrong": not well-formed, over the limits.
/// `Json` is nlohmann::json or nlohmann::ordered_json.
template <class Json = nlohmann::json>
Json parse_json(std::string_view text, const std::string& name, const JsonLimits& limits = {});

/// The same for a file. Throws as read_file, too.
nlohmann::json read_json(const std::filesystem::path& file, const JsonLimits& limits = {});

/// The value as text, with `indent` blanks a level, or on one line (-1). What is not UTF-8 in it (names of
/// files may be any bytes) becomes U+FFFD.
template <class Json>
std::string json_text(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace ohb
