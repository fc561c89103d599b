// Tar files with nothing in them that changes from run to run.
#pragma once

#include <string>

namespace ohb::exports {

/// One member of a POSIX ustar archive: header, content, padding; owner 0, mode 644, time 0. Throws
/// InputError for a name of more than 100 bytes or a content of 8 GiB or more, which ustar cannot hold.
std::string tar_member(const std::string& name, const std::string& content);

/// The two empty blocks at the end.
std::string tar_end();

}  // namespace ohb::exports
