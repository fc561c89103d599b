// Names of materials and groups as the words that they are made of.
#pragma once

#include <string>
#include <vector>

namespace ohb::commands {

/// The words of a name, in lower case: "Wolf3D_Headwear.001" is wolf, d, headwear; "LeftArm" is left, arm;
/// "HAIRBand" is hair, band. They end at anything but letters and at capitals; bytes beyond ASCII are
/// letters.
std::vector<std::string> words_of_name(const std::string& name);

/// The first of `alternatives` that is in the words: "skin|*shirt|running shoe". Each is a word or several
/// that follow each other, with * and ? as globs know them; a plural matches its singular. "" if none is.
std::string matching_word(const std::string& alternatives, const std::vector<std::string>& words);

}  // namespace ohb::commands
