#include "dataset/model/error.h"

namespace ohb {
namespace {

std::string one_line(const std::string& file, const std::string& place, const std::string& cause,
                     const std::string& mend) {
  std::string line = file;
  if (!place.empty()) line += (line.empty() ? "" : ": ") + place;
  line += (line.empty() ? "" : ": ") + cause;
  if (!mend.empty()) line += "; " + mend;
  for (char& c : line)
    if (c == '\n' || c == '\r') c = ' ';
  return line;
}

}  // namespace

InputError::InputError(const std::string& file, const std::string& place, const std::string& cause,
                       const std::string& mend)
    : std::runtime_error(one_line(file, place, cause, mend)) {}

bool speaks_of_memory(const std::string& message) {
  for (const char* part : {"ot enough memory", "llocate memory", "bad_alloc", "ut of memory", "MemoryError",
                           "esource temporarily unavailable"})
    if (message.find(part) != std::string::npos) return true;
  return false;
}

TryAgainError::TryAgainError(const std::string& file, const std::string& cause, const std::string& mend)
    : std::runtime_error(one_line(file, "", cause, mend)) {}

}  // namespace ohb
