// Files that were never what their names say: pointers to a version-control store, web pages, archives.
#pragma once

#include <filesystem>
#include <string_view>

namespace ohb {

/// `start`: the file's first bytes, a few hundred or all. Throws InputError that names what the file is and
/// how to get the real one, if it is a pointer of Git LFS or git-annex, a link that was checked out as text,
/// a web page or error message, an archive, or a model or picture of another format than its name says. Does
/// nothing for everything else: call it where a file is not what its name promises, and before text formats
/// that would take such a file for text of theirs.
void refuse_foreign_content(const std::filesystem::path& file, std::string_view start);

/// The part that no reader could mean, whatever it reads: pointers of version-control stores.
void refuse_pointer(const std::filesystem::path& file, std::string_view start);

}  // namespace ohb
