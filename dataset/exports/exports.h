// The export command: a dataset in other forms.
#pragma once

#include <filesystem>
#include <string>

namespace ohb::exports {

enum class Form { kPng, kWebDataset, kPage };

struct ExportJob {
  std::filesystem::path input, output;
  Form form = Form::kPng;
  int bits = 8;               // of PNG: 8 or 16
  int samples_a_shard = 100;  // of tar files
  bool quiet = false;
};

struct ExportReport {
  size_t samples = 0, people = 0, files = 0;
};

/// Writes job.output whole: kPng: a folder a sample and README.md; kWebDataset: shard-000000.tar ... and
/// README.md; kPage: index.html, thumbnails and CARD.md. Equal samples give equal bytes for any number of
/// threads. Throws InputError (index_samples, output), TryAgainError (disk full, SIGINT or SIGTERM: nothing
/// is left).
ExportReport export_samples(const ExportJob& job);

}  // namespace ohb::exports
