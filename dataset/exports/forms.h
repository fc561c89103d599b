// One function a form; each fills a new folder and says how many files it wrote.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "dataset/exports/exports.h"
#include "dataset/exports/sample_index.h"
#include "dataset/model/sample.h"

namespace ohb::exports {

size_t write_png_folders(const SampleIndex& index, const ExportJob& job, const std::filesystem::path& folder);
size_t write_shards(const SampleIndex& index, const ExportJob& job, const std::filesystem::path& folder);
size_t write_page(const SampleIndex& index, const ExportJob& job, const std::filesystem::path& folder);

/// What a sample is, for its JSON: person, split, view, the person's and the header's attributes.
nlohmann::ordered_json sample_json(const SampleIndex& index, const IndexedSample& sample,
                                   const ExrAttributes& attributes);

/// CARD.md: counts, balance, lights, licences. `lights`: of each sample, in its order. `has_realism`:
/// realism.png is beside it.
std::string card_text(const SampleIndex& index, const std::vector<std::vector<std::string>>& lights,
                      bool has_realism);

/// body(i) for each sample, in any order, all threads, with a progress bar. Throws what a body threw first;
/// TryAgainError after a signal.
void for_samples(const SampleIndex& index, const ExportJob& job, const std::function<void(size_t)>& body);

}  // namespace ohb::exports
