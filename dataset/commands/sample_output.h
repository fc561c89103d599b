// The folder that render writes: its views share their settings, and render.json says which views they are.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "dataset/commands/render_samples.h"

namespace ohb::commands {

/// Everything that decides about the pixels of a job's views but which view it is, as header attributes.
ExrAttributes settings_of(const RenderJob& job, const std::string& human, const std::string& model_identity,
                          const std::vector<Environment>& environments, const Camera& camera);

/// What was rendered with, where it is less than everything; for the header.
void add_needs(const RenderJob& job, const renderer::PreparedScene& prepared, ExrAttributes& attributes);
/// What a goal reached; for the header.
void add_reached(const renderer::ErrorReport& error, ExrAttributes& attributes);

/// "view_007"
std::string view_name(int view);

/// `quality` and `error` of render.json.
nlohmann::json quality_json(const RenderJob& job, const renderer::PreparedScene& prepared);

class SampleOutput {
 public:
  /// Makes or takes over the folder and writes its settings, before the first view: what a killed job leaves
  /// is known for what it is. Views of other settings, and view files of which nothing is known, are removed
  /// if `overwrites` says so, else refused. Throws InputError: those; a folder of another kind or that cannot
  /// be written; TryAgainError: disk full.
  SampleOutput(const std::filesystem::path& folder, ExrAttributes settings, bool overwrites);

  std::filesystem::path file_of(int view) const;
  /// The header of a view: the settings, which view it is, and the identity of the settings.
  ExrAttributes attributes_of(int view) const;
  /// Is the view there, whole and with these settings? Throws InputError for a file of that name that no job
  /// of this folder wrote, unless overwriting.
  bool is_done(int view) const;
  /// Lists the view in render.json, with what it cost. One that was there keeps its line.
  void add(const RenderedView& view, const RenderJob& job, const RenderReport& report);

 private:
  void remove_views() const;
  void write() const;

  std::filesystem::path folder_;
  ExrAttributes settings_;
  std::string identity_;
  int view_count_ = 0;
  bool overwrites_ = false;
  nlohmann::ordered_json json_;
};

}  // namespace ohb::commands
