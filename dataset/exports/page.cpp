// index.html, which needs no server: data.js lists the samples, pictures are beside it.
#include <cmath>

#include "dataset/exports/encodings.h"
#include "dataset/exports/forms.h"
#include "dataset/exports/grid.h"
#include "dataset/exports/realism.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/data_files.h"
#include "dataset/model/json_text.h"

namespace ohb::exports {
namespace fs = std::filesystem;
namespace {

constexpr int kThumbnail_px = 128, kMap_px = 256;

/// One picture a person, wider than high.
ByteImage contact_sheet(const std::vector<ByteImage>& people) {
  return grid_of(people, static_cast<int>(std::ceil(std::sqrt(1.6 * static_cast<double>(people.size())))));
}

/// CARD.md and its figure; how many files that makes.
size_t write_card(const SampleIndex& index, const std::vector<std::vector<std::string>>& lights,
                  const ExportJob& job, const fs::path& folder) {
  const ByteImage realism = realism_figure(index, {}, job.quiet);
  const bool has_realism = !realism.values.empty();
  if (has_realism) write_png(folder / "realism.png", realism);
  write_file_atomically(folder / "CARD.md", card_text(index, lights, has_realism));
  return has_realism ? 2 : 1;
}

/// JSON in a script: "</script>" in a name must not end it.
std::string script_text(const nlohmann::ordered_json& json) {
  std::string text = json_text(json), safe;
  for (const char c : text)
    if (c == '<')
      safe += "\\u003c";
    else
      safe += c;
  return safe;
}

}  // namespace

size_t write_page(const SampleIndex& index, const ExportJob& job, const fs::path& folder) {
  std::vector<nlohmann::ordered_json> entries(index.samples.size());
  std::vector<std::vector<std::string>> lights(index.samples.size());
  std::vector<ByteImage> first_of_person(index.people.size());
  for (size_t k = 0; k < index.people.size(); ++k) make_folders(folder / "pictures" / std::to_string(k));
  for_samples(index, job, [&](size_t i) {
    const IndexedSample& indexed = index.samples[i];
    const Sample sample = read_sample(indexed.file);
    const std::vector<EncodedMap> maps = encoded_maps(sample, indexed.file.string());
    std::vector<ByteImage> pictures;
    nlohmann::ordered_json names = nlohmann::ordered_json::array();
    for (const EncodedMap& map : maps) {
      pictures.push_back(thumbnail(map.image, kMap_px));
      names.push_back(map.name);
    }
    for (const SampleLight& light : sample.lights) lights[i].push_back(light.name);
    // The first lit picture stands for the sample; without lights the albedo.
    const EncodedMap& shown = sample.lights.empty() ? maps[2] : maps[7];
    const std::string stem = "pictures/" + std::to_string(indexed.person) + "/" + indexed.view;
    const ByteImage small = thumbnail(shown.image, kThumbnail_px);
    write_png(folder / (stem + ".png"), small);
    write_png(folder / (stem + "_maps.png"), grid_of(pictures, static_cast<int>(pictures.size())));
    const bool is_first = i == 0 || index.samples[i - 1].person != indexed.person;
    if (is_first) first_of_person[indexed.person] = small;
    entries[i] = {{"person", indexed.person},
                  {"view", indexed.view},
                  {"lights", lights[i]},
                  {"maps", names},
                  {"stem", stem}};
  });
  nlohmann::ordered_json people = nlohmann::ordered_json::array();
  for (const IndexedPerson& person : index.people)
    people.push_back({{"id", person.id}, {"split", person.split}, {"attributes", person.attributes}});
  const nlohmann::ordered_json data = {{"name", index.name}, {"people", people}, {"samples", entries}};
  write_file_atomically(folder / "data.js", "const DATA = " + script_text(data) + ";\n");
  write_file_atomically(folder / "index.html", read_file(program_file("assets/export/index.html")));
  write_png(folder / "contact_sheet.png", contact_sheet(first_of_person));
  return 2 * index.samples.size() + 3 + write_card(index, lights, job, folder);
}

}  // namespace ohb::exports
