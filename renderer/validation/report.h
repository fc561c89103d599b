// A validation as files: validate.json and a page to look at.
#pragma once

#include <filesystem>
#include <string>

#include "renderer/validation/validate.h"

namespace ohb::validation {

/// Everything but the pictures as JSON text (docs/commands/validate.md lists the fields).
std::string validation_json(const Validation& validation);

/// The page: verdict in words, pictures (files of that folder), tables, settings. Plain HTML and CSS, nothing
/// is loaded from elsewhere.
std::string validation_html(const Validation& validation);

/// Writes validate.json, index.html, its PNG pictures, and ours.exr and cycles.exr (mean and variance of one
/// seed, float, linear Rec. 709) into an existing folder. Throws as write_exr and write_png.
void write_validation(const std::filesystem::path& folder, const Validation& validation);

}  // namespace ohb::validation
