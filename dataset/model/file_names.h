// Names of files as other machines write them: other encodings, other case, composed or decomposed letters.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ohb {

/// What a name may stand for, for comparison: UTF-8 in Unicode's compatibility form with case folded
/// (NFKC_Casefold), percent escapes decoded, blanks at the ends removed. A name of ASCII has one reading;
/// others are also read as Windows-1252, GB18030, Shift-JIS, EUC-KR, CP437, CP850 and Mac Roman, since a file
/// may have been named on one such machine and unpacked on another. The first is that of UTF-8 if it is that.
std::vector<std::string> name_readings(std::string_view name);

/// Whether two sets of readings have one in common.
bool share_a_reading(const std::vector<std::string>& a, const std::vector<std::string>& b);

/// The name as valid UTF-8, for messages: as it is, else read as Latin-1.
std::string readable_name(std::string_view name);

/// Letters to insert, remove or exchange to make one of the other (Levenshtein, bytes of the first readings).
size_t name_distance(std::string_view a, std::string_view b);

/// %XX decoded; anything else stays.
std::string without_percent_escapes(std::string_view name);

}  // namespace ohb
