// The paper's layout: a folder a set with its mask, maps and relit pictures.
#include <atomic>

#include "dataset/exports/encodings.h"
#include "dataset/exports/forms.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/json_text.h"

namespace ohb::exports {
namespace fs = std::filesystem;

size_t write_png_folders(const SampleIndex& index, const ExportJob& job, const fs::path& folder) {
  std::atomic<size_t> files{1};
  for_samples(index, job, [&](size_t i) {
    const IndexedSample& indexed = index.samples[i];
    const IndexedPerson& person = index.people[indexed.person];
    const fs::path set =
        folder / (person.split.empty() ? "samples" : person.split) / person.id / indexed.view;
    make_folders(set);
    const Sample sample = read_sample(indexed.file);
    for (const EncodedMap& map : encoded_maps(sample, indexed.file.string())) {
      write_png(set / (map.name + ".png"), map.image, job.bits);
      ++files;
    }
    nlohmann::ordered_json json = sample_json(index, indexed, sample.attributes);
    json["displacement_range_cm"] = displacement_range_cm(sample, indexed.file.string());
    write_file_atomically(set / "sample.json", json_text(json, 1) + "\n");
    ++files;
  });
  write_file_atomically(folder / "README.md",
                        "# " + index.name + " as PNG, " + std::to_string(job.bits) +
                            " bits\n\nSPLIT/PERSON/VIEW/: one set, at the sample's size. Written by "
                            "openhumanbrdf export --png.\n\n" +
                            encodings_text(job.bits));
  return files;
}

}  // namespace ohb::exports
