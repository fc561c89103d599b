// Finds the files that a scan names (pictures, .mtl), however another machine wrote the names.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dataset/model/scan.h"

namespace ohb {

/// Looks, in this order: at the name as written; at the end of its path, longest first ("textures/skin.png",
/// then "skin.png" of "C:\work\textures\skin.png"), from the folder of the file that names it, then from the
/// scan's; at its last part in sub-folders that usually hold pictures, and in such folders beside the scan's.
/// Letters of other case, other normalisation and other encodings are the same, quotes and blanks around the
/// name count for nothing. No other folder is looked at, and of each at most kMaxEntries names.
/// What is found otherwise than written is said in the scan's notes, once a name.
class ScanFiles {
 public:
  static constexpr size_t kMaxEntries = 20000;

  /// `scan.file` is set; `scan` outlives this and takes the notes and what is missing.
  explicit ScanFiles(Scan& scan) : scan_(scan) {}
  ScanFiles(const ScanFiles&) = delete;
  ScanFiles& operator=(const ScanFiles&) = delete;

  /// The picture that `referrer` (the scan or its .mtl) names at `place` by one of `names`, the likeliest
  /// first; "<UDIM>" stands for the number of the first tile. A picture that is not there, is not certain
  /// (two files fit) or has no image's header goes into `scan.missing` and comes back empty.
  ScanPicture picture(const std::filesystem::path& referrer, const std::string& place,
                      const std::vector<std::string>& names);

  /// A file that is no picture. Nothing if it is not there; nothing is recorded then.
  std::optional<std::filesystem::path> file(const std::filesystem::path& referrer, const std::string& place,
                                            const std::string& name);

  /// The name in the folder of `referrer` that is nearest to `name` and ends in one of `extensions` (lower
  /// case, with dot); empty if none is near.
  std::string nearest_name(const std::filesystem::path& referrer, const std::string& name,
                           const std::vector<std::string>& extensions);

  /// "<file>: <place>: <cause>" into `scan.missing`.
  void add_missing(const std::filesystem::path& referrer, const std::string& place, const std::string& cause,
                   const std::string& mend);

 private:
  struct Entry {
    std::string name;
    std::vector<std::string> readings;
    bool is_folder = false;
  };
  struct Found {
    std::filesystem::path file;                   // empty: none
    std::vector<std::filesystem::path> also_fit;  // others that fit as well and are not the same bytes
    bool is_as_written = false;
  };

  Found find(const std::filesystem::path& referrer, const std::vector<std::string>& names);
  Found find_first(const std::filesystem::path& referrer, const std::vector<std::string>& names);
  Found find_by_path(const std::filesystem::path& folder, const std::vector<std::string>& parts);
  Found find_in_usual_folders(const std::string& name);
  Found find_in(const std::filesystem::path& folder, const std::string& name, bool is_folder);
  const std::vector<Entry>& entries(const std::filesystem::path& folder);
  std::vector<std::filesystem::path> usual_folders();
  std::string shown_name(const std::filesystem::path& file) const;
  void note_found(const std::filesystem::path& referrer, const std::string& place, const std::string& name,
                  const Found& found);

  Scan& scan_;
  std::map<std::filesystem::path, std::vector<Entry>> entries_;
  std::map<std::pair<std::filesystem::path, std::vector<std::string>>, Found> found_;
};

}  // namespace ohb
