#include "dataset/model/sample_listing.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"

namespace ohb {
namespace fs = std::filesystem;
namespace {

constexpr std::array<const char*, 3> kOfOneView = {"ohb:view", "ohb:turn_deg", "ohb:identity"};
// What rendering found out: ohb:reached..., ohb:needs...; and what `produce` draws for each view: ohb:set...
constexpr std::array<const char*, 3> kFound = {"ohb:reached.", "ohb:needs.", "ohb:set."};

SampleListing listing_of(const nlohmann::ordered_json& json) {
  SampleListing listing;
  listing.identity = json.at("identity").get<std::string>();
  for (const auto& [name, value] : json.at("settings").items())
    listing.settings.emplace_back(name, value.get<std::string>());
  for (const auto& view : json.at("views")) listing.views.push_back(view.at("file").get<std::string>());
  std::sort(listing.views.begin(), listing.views.end());
  return listing;
}

}  // namespace

bool is_view_file(const fs::path& file) {
  const std::string stem = file.stem().string(), start = "view_";
  return file.extension() == ".exr" && stem.size() >= start.size() + 3 && stem.rfind(start, 0) == 0 &&
         std::all_of(stem.begin() + static_cast<long>(start.size()), stem.end(),
                     [](char c) { return c >= '0' && c <= '9'; });
}

ExrAttributes shared_attributes(const ExrAttributes& attributes) {
  ExrAttributes shared;
  for (const auto& attribute : attributes) {
    const std::string& name = attribute.first;
    const bool is_own = std::find(kOfOneView.begin(), kOfOneView.end(), name) != kOfOneView.end();
    const bool is_found = std::any_of(kFound.begin(), kFound.end(),
                                      [&](const char* start) { return name.rfind(start, 0) == 0; });
    if (!is_own && !is_found) shared.push_back(attribute);
  }
  return shared;
}

std::string identity_of(ExrAttributes shared) {
  std::sort(shared.begin(), shared.end());
  std::string text;
  for (const auto& [name, value] : shared) text.append(name).append("=").append(value).append("\n");
  return sha256_of(text);
}

std::optional<SampleListing> read_sample_listing(const fs::path& folder) {
  const fs::path file = folder / "render.json";
  if (!fs::exists(file)) return std::nullopt;
  try {
    const auto json = parse_json<nlohmann::ordered_json>(read_file(file), file.string(), kListingLimits);
    if (!json.is_object() || !json.contains("identity")) return std::nullopt;
    return listing_of(json);
  } catch (const nlohmann::json::exception&) {
    throw InputError(file.string(), "", "is damaged",
                     "remove it and the views beside it, and render them again");
  }
}

}  // namespace ohb
