// What a folder of samples says of itself: render.json names the settings that its views share, and the
// views.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dataset/model/image.h"

namespace ohb {

/// "view_", at least three digits, ".exr".
bool is_view_file(const std::filesystem::path& file);

/// Those of a view's attributes that all views of one job share: everything that decides about its pixels but
/// which view it is, and nothing that rendering found out or that was drawn for this view alone (ohb:set...).
ExrAttributes shared_attributes(const ExrAttributes& attributes);

/// SHA-256 of shared attributes in any order; ohb:identity of each view that has them.
std::string identity_of(ExrAttributes shared);

struct SampleListing {
  std::string identity;
  ExrAttributes settings;          // in file order
  std::vector<std::string> views;  // file names, sorted
};
/// What render.json in that folder says; none if there is no such file or it is of a version before
/// identities. Throws InputError if it cannot be read or is damaged.
std::optional<SampleListing> read_sample_listing(const std::filesystem::path& folder);

}  // namespace ohb
