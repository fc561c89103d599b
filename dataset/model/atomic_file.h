// Outputs appear whole or not at all: written to a temporary name in the same folder, synced, renamed.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace ohb {

/// Calls `write(temporary)`, syncs what it wrote and renames it to `file` (replacing an older one; a link is
/// followed). The temporary keeps the extension (writers choose the format by it), and is removed if anything
/// throws; what killed writers left in that folder is removed too (temporary.h).
/// Throws InputError (folder missing, no permission) or TryAgainError (disk full).
void write_file_atomically(const std::filesystem::path& file,
                           const std::function<void(const std::filesystem::path& temporary)>& write);

/// The same for text or bytes at hand.
void write_file_atomically(const std::filesystem::path& file, const std::string& content);

/// Makes a folder and those above it, if they are not there. Throws as write_file_atomically.
void make_folders(const std::filesystem::path& folder);

/// The whole file as bytes. Throws InputError if it does not exist or cannot be read.
std::string read_file(const std::filesystem::path& file);

/// SHA-256 of a file's bytes, or of bytes at hand, as 64 hexadecimal digits. Throws as read_file.
std::string sha256_of_file(const std::filesystem::path& file);
std::string sha256_of(const std::string& bytes);

}  // namespace ohb
