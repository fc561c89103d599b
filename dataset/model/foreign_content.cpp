#include "dataset/model/foreign_content.h"

#include <algorithm>
#include <cctype>

#include "dataset/model/error.h"

namespace ohb {
namespace fs = std::filesystem;
using namespace std::string_view_literals;
namespace {

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

/// Without blanks and ends of line at both ends.
std::string_view stripped(std::string_view text) {
  constexpr const char* kBlank = " \t\r\n";
  const size_t first = text.find_first_not_of(kBlank);
  return first == std::string_view::npos ? std::string_view()
                                         : text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

bool starts(std::string_view text, std::string_view with) {
  return text.substr(0, with.size()) == with;
}

struct Kind {
  std::string_view magic;
  const char* what;
  const char* mend;
  std::string_view endings = "";  // of files that may begin so
};
constexpr const char* kUnpack = "unpack it and name the file in it";
constexpr const char* kRename = "give the file the ending of what it is";
constexpr Kind kKinds[] = {
    {"PK\3\4"sv, "a zip archive", kUnpack},
    {"PK\5\6"sv, "an empty zip archive", "download it again"},
    {"\x1f\x8b"sv, "a gzip archive", kUnpack},
    {"7z\xbc\xaf\x27\x1c"sv, "a 7z archive", kUnpack},
    {"Rar!\x1a\7"sv, "a RAR archive", kUnpack},
    {"\xfd"
     "7zXZ\0"sv,
     "an xz archive", kUnpack},
    {"BZh"sv, "a bzip2 archive", kUnpack},
    {"\x28\xb5\x2f\xfd"sv, "a zstd archive", kUnpack},
    {"glTF"sv, "a binary glTF file", "give it the ending .glb", ".glb.gltf"},
    {"Kaydara FBX Binary"sv, "a binary FBX file", "give it the ending .fbx", ".fbx"},
    {"; FBX "sv, "an FBX text file", "give it the ending .fbx", ".fbx"},
    {"BLENDER"sv, "a Blender file", "export the mesh as .glb, .obj or .fbx", ".blend"},
    {"ply\n"sv, "a PLY file", "export the mesh as .glb, .obj or .fbx", ".ply"},
    {"ply\r\n"sv, "a PLY file", "export the mesh as .glb, .obj or .fbx", ".ply"},
    {"\x89PNG"sv, "a PNG picture", kRename},
    {"\xff\xd8\xff"sv, "a JPEG picture", kRename},
    {"GIF8"sv, "a GIF picture", "export it as PNG"},
    {"%PDF-"sv, "a PDF document", "download the file itself"},
};

bool is_web_page(std::string_view start) {
  if (starts(start, "\xef\xbb\xbf")) start.remove_prefix(3);
  const std::string text = lower(stripped(start.substr(0, 512)));
  return starts(text, "<!doctype html") || starts(text, "<html") || starts(text, "<head") ||
         (starts(text, "<?xml") && text.find("<html") != std::string::npos) ||
         (starts(text, "<?xml") && text.find("<error>") != std::string::npos);  // S3 and its like
}

/// A link that was checked out as a text that names its target: one short line that ends as the file does.
bool is_link_text(const fs::path& file, std::string_view start) {
  const std::string extension = lower(file.extension().string());
  const std::string_view line = stripped(start);
  return !extension.empty() && line.size() > extension.size() && line.size() < 256 &&
         line.find_first_of("\n\r\0 \t"sv) == std::string_view::npos &&
         lower(line.substr(line.size() - extension.size())) == extension;
}

}  // namespace

void refuse_pointer(const fs::path& file, std::string_view start) {
  if (starts(start, "version https://git-lfs.github.com/spec/") ||
      starts(start, "version https://hawser.github.com/spec/") || starts(start, "version http://git-media"))
    throw InputError(file.string(), "", "is a Git LFS pointer: the file itself was never downloaded",
                     "fetch it with `git lfs pull` in its repository, or download it by itself");
  if ((starts(start, "/annex/objects/") || starts(start, "../.git/annex/objects/") ||
       starts(start, ".git/annex/objects/")) &&
      start.size() < 1024)
    throw InputError(file.string(), "", "is a git-annex pointer: the file itself was never downloaded",
                     "fetch it with `git annex get` in its repository");
}

void refuse_foreign_content(const fs::path& file, std::string_view start) {
  refuse_pointer(file, start);
  if (is_web_page(start))
    throw InputError(file.string(), "", "is a web page or a server's error message, saved under this name",
                     "download the file itself (open this one in a browser to see what the server said)");
  const std::string extension = lower(file.extension().string());
  for (const Kind& kind : kKinds)
    if (starts(start, kind.magic) && (extension.empty() || kind.endings.find(extension) == kind.endings.npos))
      throw InputError(file.string(), "", std::string("is ") + kind.what + ", whatever its name says",
                       kind.mend);
  if (start.size() > 262 && start.substr(257, 5) == "ustar")
    throw InputError(file.string(), "", "is a tar archive, whatever its name says", kUnpack);
  if (is_link_text(file, start))
    throw InputError(file.string(), "",
                     "holds nothing but a file name ('" + std::string(stripped(start)) +
                         "'): a link that was copied as text",
                     "copy the file that it names to this place");
}

}  // namespace ohb
