// What a command prints on stdout.
#pragma once

namespace ohb {

/// Sends what was printed on its way. Throws TryAgainError if any of it could not be written (a full disk, a
/// closed pipe): results that nobody gets are no success.
void flush_results();

}  // namespace ohb
