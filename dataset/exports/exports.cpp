#include "dataset/exports/exports.h"

#include "dataset/exports/forms.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/parallel.h"
#include "dataset/model/progress.h"

namespace ohb::exports {
namespace {

const char* kind_of(Form form) {
  switch (form) {
    case Form::kPng:
      return "PNG export";
    case Form::kWebDataset:
      return "tar shards";
    case Form::kPage:
      return "page of a dataset";
  }
  return "";
}

}  // namespace

void for_samples(const SampleIndex& index, const ExportJob& job, const std::function<void(size_t)>& body) {
  Progress progress("samples", index.samples.size(), job.quiet);
  parallel_for_each(0, static_cast<int>(index.samples.size()), [&](int i) {
    throw_if_interrupted();
    body(static_cast<size_t>(i));
    progress.add();
  });
}

nlohmann::ordered_json sample_json(const SampleIndex& index, const IndexedSample& sample,
                                   const ExrAttributes& attributes) {
  const IndexedPerson& person = index.people[sample.person];
  nlohmann::ordered_json json = {{"person", person.id}, {"split", person.split}, {"view", sample.view}};
  json["person_attributes"] = nlohmann::ordered_json::object();
  for (const auto& [name, value] : person.attributes) json["person_attributes"][name] = value;
  json["header"] = nlohmann::ordered_json::object();
  for (const auto& [name, value] : attributes) json["header"][name] = value;
  return json;
}

ExportReport export_samples(const ExportJob& job) {
  const SampleIndex index = index_samples(job.input);
  AtomicFolder folder(job.output, kind_of(job.form), {job.input});
  ExportReport report{index.samples.size(), index.people.size(), 0};
  switch (job.form) {
    case Form::kPng:
      report.files = write_png_folders(index, job, folder.path());
      break;
    case Form::kWebDataset:
      report.files = write_shards(index, job, folder.path());
      break;
    case Form::kPage:
      report.files = write_page(index, job, folder.path());
      break;
  }
  folder.commit();
  return report;
}

}  // namespace ohb::exports
