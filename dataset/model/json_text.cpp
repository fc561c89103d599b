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

/// Counts what the parser meets and keeps nothing. Errors are left to the parser that follows.
template <class Json>
struct WithinLimits : nlohmann::json_sax<Json> {
  using Base = nlohmann::json_sax<Json>;

  WithinLimits(const std::string& name, const JsonLimits& limits) : name_(name), limits_(limits) {}

  bool null() override { return count(); }
  bool boolean(bool) override { return count(); }
  bool number_integer(typename Base::number_integer_t) override { return count(); }
  bool number_unsigned(typename Base::number_unsigned_t) override { return count(); }
  bool number_float(typename Base::number_float_t, const typename Base::string_t&) override {
    return count();
  }
  bool string(typename Base::string_t&) override { return count(); }
  bool binary(typename Base::binary_t&) override { return count(); }
  bool key(typename Base::string_t&) override { return true; }
  bool start_object(std::size_t) override { return enter(); }
  bool start_array(std::size_t) override { return enter(); }
  bool end_object() override { return leave(); }
  bool end_array() override { return leave(); }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) override {
    return false;
  }

 private:
  bool count() {
    if (++values_ > limits_.values)
      throw InputError(name_, "JSON", "holds more than " + std::to_string(limits_.values) + " values",
                       "it is damaged, or no file for this program");
    return true;
  }
  bool enter() {
    if (depth_++ >= limits_.depth)
      throw InputError(name_, "JSON", "is nested deeper than " + std::to_string(limits_.depth) + " levels",
                       "it is damaged, or no file for this program");
    return count();
  }
  bool leave() {
    --depth_;
    return true;
  }

  const std::string& name_;
  const JsonLimits& limits_;
  int depth_ = 0;
  size_t values_ = 0;
};

}  // namespace

template <class Json>
Json parse_json(std::string_view text, const std::string& name, const JsonLimits& limits) {
  try {
    // By itself first: a parser that asks about each value while it builds them walks over all of an object's
    // or array's members each time that one ends.
    WithinLimits<Json> within(name, limits);
    Json::sax_parse(text.begin(), text.end(), &within);
    return Json::parse(text.begin(), text.end());
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
