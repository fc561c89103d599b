// WebDataset: tar files whose members of one sample share what stands before the first dot of their names.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "dataset/exports/forms.h"
#include "dataset/exports/tar.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/json_text.h"
#include "dataset/model/progress.h"
#include "dataset/model/temporary.h"

namespace ohb::exports {
namespace fs = std::filesystem;
namespace {

/// A dot would end the key; two people never share one.
std::string key_of(const SampleIndex& index, const IndexedSample& sample) {
  std::string key;
  for (const char c : index.people[sample.person].id)
    if (c == '.')
      key += "%2e";
    else if (c == '%')
      key += "%25";
    else
      key += c;
  return key + "_" + sample.view;
}

std::string split_of(const SampleIndex& index, const IndexedSample& sample) {
  const std::string& split = index.people[sample.person].split;
  return split.empty() ? "samples" : split;
}

std::vector<std::string> splits_of(const SampleIndex& index) {
  std::vector<std::string> splits;
  for (const IndexedSample& sample : index.samples)
    if (std::find(splits.begin(), splits.end(), split_of(index, sample)) == splits.end())
      splits.push_back(split_of(index, sample));
  std::sort(splits.begin(), splits.end());
  return splits;
}

}  // namespace

size_t write_shards(const SampleIndex& index, const ExportJob& job, const fs::path& folder) {
  size_t files = 1;
  Progress progress("samples", index.samples.size(), job.quiet);
  for (const std::string& split : splits_of(index)) {
    std::vector<const IndexedSample*> samples;
    for (const IndexedSample& sample : index.samples)
      if (split_of(index, sample) == split) samples.push_back(&sample);
    const auto most = static_cast<size_t>(job.samples_a_shard);
    for (size_t begin = 0; begin < samples.size(); begin += most) {
      const fs::path shard = folder / fmt::format("{}-{:06}.tar", split, begin / most);
      std::ofstream out(shard, std::ios::binary);
      for (size_t k = begin; k < std::min(begin + most, samples.size()); ++k) {
        throw_if_interrupted();
        const IndexedSample& sample = *samples[k];
        const std::string key = key_of(index, sample);
        out << tar_member(key + ".exr", read_file(sample.file));
        out << tar_member(
            key + ".json",
            json_text(sample_json(index, sample, read_sample_attributes(sample.file)), 1) + "\n");
        progress.add();
      }
      out << tar_end();
      out.close();
      if (!out) throw_write_error(shard, ENOSPC);
      ++files;
    }
  }
  write_file_atomically(
      folder / "README.md",
      "# " + index.name +
          " as tar shards (WebDataset)\n\nSPLIT-000000.tar, ...: of each sample "
          "`KEY.exr`, the sample as openhumanbrdf rendered it, and `KEY.json`, its person, split, view and "
          "header. Written by openhumanbrdf export --webdataset; equal samples give equal bytes.\n");
  return files;
}

}  // namespace ohb::exports
