#include "learner/checkpoint.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "dataset/model/error.h"
#include "dataset/model/json_text.h"
#include "learner/safetensors.h"

namespace ohb::learner {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;
using torch::Tensor;

constexpr const char *kHeaderKey = "humanmaterial", *kModel = "model.", *kFirst = "adam.first.",
                     *kSecond = "adam.second.", *kAverage = "average.";
constexpr const char *kStem = "step_", *kExtension = ".safetensors";
constexpr double kMinWidth = 0.01, kMaxWidth = 4;
constexpr int64_t kMaxSize_px = 8192;

std::vector<fs::path> checkpoints_of(const fs::path& run) {
  std::vector<fs::path> files;
  if (!fs::is_directory(run)) return files;
  for (const auto& entry : fs::directory_iterator(run)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_regular_file() && name.rfind(kStem, 0) == 0 && entry.path().extension() == kExtension)
      files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());  // names are of equal length
  return files;
}

json header_of(const TensorFile& content, const fs::path& file) {
  const auto refuse = [&](const std::string& cause) -> InputError {
    return {file.string(), "header", cause, "give a file that humanmaterial train wrote"};
  };
  const auto text = content.metadata.find(kHeaderKey);
  if (text == content.metadata.end()) throw refuse("is not of a humanmaterial checkpoint");
  const json header = parse_json(text->second, file.string() + ": header");
  if (!header.is_object()) throw refuse("is no JSON");
  const auto number = [&](const char* key) {
    if (!header.contains(key) || !header[key].is_number())
      throw refuse(std::string("has no number '") + key + "'");
    return header[key].get<double>();
  };
  if (number("format") != kCheckpointFormat)
    throw refuse("is of another format than 1: use the version that wrote it");
  if (!header.contains("task") || !header["task"].is_string()) throw refuse("has no task");
  if (std::none_of(std::begin(kTasks), std::end(kTasks),
                   [&](Task task) { return header["task"] == name_of(task); }))
    throw refuse("is of " + json_text(header["task"]) + ", which is no model of this version");
  if (const double width = number("width"); !(width >= kMinWidth && width <= kMaxWidth))
    throw refuse("has a width outside 0.01 to 4");
  if (const double size = number("size_px");
      !(size >= kResolutionStep && size <= kMaxSize_px) || std::fmod(size, kResolutionStep) != 0)
    throw refuse("has a size that is no multiple of 16 from 16 to 8192 px");
  number("step");
  if (!header["step"].is_number_unsigned()) throw refuse("has a step that is no whole number from 0 on");
  for (const char* people : {"trained_on", "held_out"})
    if (const auto names = header.find(people);
        names != header.end() &&
        !(names->is_array() &&
          std::all_of(names->begin(), names->end(), [](const json& name) { return name.is_string(); })))
      throw refuse(std::string("has a '") + people + "' that is no list of names");
  return header;
}

using Named = std::map<std::string, Tensor>;

/// The tensor of that name, taken out of `tensors`, as float32.
Tensor take(Named& tensors, const std::string& name, const Tensor& like, const fs::path& file) {
  const auto found = tensors.find(name);
  const std::string place = "tensor '" + name + "'", mend = "the file belongs to another network";
  if (found == tensors.end()) throw InputError(file.string(), place, "is missing", mend);
  const Tensor tensor = found->second.to(torch::kFloat);
  if (tensor.sizes() != like.sizes())
    throw InputError(file.string(), place, "has another shape than the network's", mend);
  if (!torch::isfinite(tensor).all().item<bool>())
    throw InputError(file.string(), place, "holds NaN or infinite values", "use an earlier checkpoint");
  tensors.erase(found);
  return tensor;
}

Named named(const TensorFile& content) {
  return Named(content.tensors.begin(), content.tensors.end());
}

}  // namespace

fs::path checkpoint_file(const fs::path& run, int64_t step) {
  const std::string digits = std::to_string(step);
  return run / (kStem + std::string(digits.size() < 8 ? 8 - digits.size() : 0, '0') + digits + kExtension);
}

void save_checkpoint(const fs::path& run, const json& header, AdamW& optimiser, int keep) {
  TensorFile content;
  content.metadata[kHeaderKey] = json_text(header);
  for (const AdamW::State& s : optimiser.states()) {
    content.tensors.emplace_back(kModel + s.name, s.parameter);
    content.tensors.emplace_back(kFirst + s.name, s.first);
    content.tensors.emplace_back(kSecond + s.name, s.second);
    if (s.average.defined()) content.tensors.emplace_back(kAverage + s.name, s.average);
  }
  write_tensors(checkpoint_file(run, header.at("step")), content);
  std::vector<fs::path> files = checkpoints_of(run);
  for (size_t i = 0; i + static_cast<size_t>(keep) < files.size(); ++i) fs::remove(files[i]);
}

void save_weights(const fs::path& file, const json& header, const Network& network) {
  TensorFile content;
  content.metadata[kHeaderKey] = json_text(header);
  for (const auto& item : network.module().named_parameters())
    content.tensors.emplace_back(kModel + item.key(), item.value().detach().to(torch::kCPU).to(torch::kHalf));
  write_tensors(file, content);
}

std::optional<fs::path> newest_checkpoint(const fs::path& run) {
  const std::vector<fs::path> files = checkpoints_of(run);
  if (files.empty()) return std::nullopt;
  return files.back();
}

json read_checkpoint_header(const fs::path& file) {
  return header_of(read_tensors(file), file);
}

json load_checkpoint(const fs::path& file, AdamW& optimiser) {
  const TensorFile content = read_tensors(file);
  json header = header_of(content, file);
  Named tensors = named(content);
  std::vector<std::array<Tensor, 4>> loaded;
  for (const AdamW::State& s : optimiser.states())
    loaded.push_back({take(tensors, kModel + s.name, s.parameter, file),
                      take(tensors, kFirst + s.name, s.first, file),
                      take(tensors, kSecond + s.name, s.second, file),
                      s.average.defined() ? take(tensors, kAverage + s.name, s.average, file) : Tensor()});
  if (!tensors.empty())
    throw InputError(file.string(), "tensor '" + tensors.begin()->first + "'",
                     "belongs to no part of the network", "the file belongs to another network");
  torch::NoGradGuard no_gradients;
  for (size_t i = 0; i < loaded.size(); ++i) {
    AdamW::State& s = optimiser.states()[i];
    s.parameter.copy_(loaded[i][0]);
    s.first.copy_(loaded[i][1]);
    s.second.copy_(loaded[i][2]);
    if (s.average.defined()) s.average.copy_(loaded[i][3]);
  }
  return header;
}

LoadedNetwork load_network(const fs::path& file_or_run) {
  fs::path file = file_or_run;
  if (fs::is_directory(file_or_run)) {
    const auto newest = newest_checkpoint(file_or_run);
    file = newest ? *newest : file_or_run / kWeightsName;
  }
  const TensorFile content = read_tensors(file);
  const json header = header_of(content, file);
  Named tensors = named(content);
  LoadedNetwork loaded{
      make_network(task_from_name(header["task"]), header["width"], header.value("residual", false)), header,
      file};
  torch::NoGradGuard no_gradients;
  for (auto& item : loaded.network.module().named_parameters()) {
    item.value().copy_(take(tensors, kModel + item.key(), item.value(), file));
    // A checkpoint of a run that averages: its estimate is the average's.
    if (tensors.count(kAverage + item.key()) > 0)
      item.value().copy_(take(tensors, kAverage + item.key(), item.value(), file));
  }
  for (const auto& [name, tensor] : tensors)
    if (name.rfind(kModel, 0) == 0)
      throw InputError(file.string(), "tensor '" + name + "'", "belongs to no part of the network",
                       "the file belongs to another network");
  loaded.network.module().eval();
  return loaded;
}

}  // namespace ohb::learner
