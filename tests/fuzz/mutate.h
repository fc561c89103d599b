// Damage to bytes, as disks, editors, hostile hands and other programs' bugs do it. A function of the random
// numbers alone.
#pragma once

#include <random>
#include <string>

namespace ohb {

/// One to four changes: flipped bytes, numbers at the edges of their types, words that formats trip over,
/// blocks removed, repeated or exchanged, the end cut off; of text also numbers and deep nesting. Of a PNG
/// every other result has its checksums put right, so that the decoder sees the damage; of a GLB its lengths.
std::string mutated(const std::string& whole, std::mt19937& random);

}  // namespace ohb
