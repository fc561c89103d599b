#include "dataset/labelling/label_model.h"

#include <algorithm>
#include <cmath>

#include "dataset/model/atomic_file.h"
#include "dataset/model/data_files.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"

namespace ohb::labelling {
namespace {

using Json = nlohmann::ordered_json;

InputError model_error(const std::filesystem::path& file, const std::string& place, const std::string& what) {
  return InputError(file.string(), place, what, "install the program anew, or fit it with label_robot --fit");
}

float number_at(const Json& json, const char* name, const std::filesystem::path& file) {
  if (!json.is_object() || !json.contains(name) || !json[name].is_number() ||
      !std::isfinite(json[name].get<double>()))
    throw model_error(file, name, "is missing or no number");
  return json[name].get<float>();
}

template <size_t N>
std::array<float, N> weights_at(const Json& json, const char* name, const std::array<const char*, N>& cues,
                                const std::filesystem::path& file) {
  if (!json.contains(name) || !json[name].is_object() || json[name].size() != N)
    throw model_error(file, name, "does not have " + std::to_string(N) + " weights");
  std::array<float, N> weights{};
  for (size_t i = 0; i < N; ++i) weights[i] = number_at(json[name], cues[i], file);
  return weights;
}

template <size_t N>
Json json_of(const std::array<float, N>& weights, const std::array<const char*, N>& cues) {
  Json json;
  for (size_t i = 0; i < N; ++i) json[cues[i]] = std::round(weights[i] * 1e4f) / 1e4;
  return json;
}

constexpr std::array<const char*, kPartCount> kPartNames = {"skin", "hair", "garment"};

Calibration calibration_at(const Json& json, const char* name, const std::filesystem::path& file) {
  const std::string place = std::string("calibration of ") + name;
  if (!json.is_object() || !json.contains(name) || !json[name].is_array() || json[name].empty())
    throw model_error(file, place, "is no list");
  Calibration found;
  for (const Json& knot : json[name]) {
    found.lead.push_back(number_at(knot, "lead", file));
    found.right.push_back(number_at(knot, "right", file));
  }
  for (size_t i = 0; i < found.lead.size(); ++i) {
    const bool ascends =
        i == 0 || (found.lead[i] > found.lead[i - 1] && found.right[i] >= found.right[i - 1]);
    if (!ascends || found.right[i] < 0 || found.right[i] > 1)
      throw model_error(file, place, "does not ascend within [0,1]");
  }
  return found;
}

}  // namespace

PartValues part_probability(const LabelModel& model, const Cues& cues) {
  PartValues p{};
  for (int k = 0; k < kGarment; ++k)
    for (int i = 0; i < kCueCount; ++i) p[k] += model.part_weights[k][i] * cues[i];
  const float highest = *std::max_element(p.begin(), p.end());
  float sum = 0;
  for (float& value : p) sum += value = std::exp(value - highest);
  for (float& value : p) value /= sum;
  return p;
}

float calibrated(const Calibration& calibration, float lead) {
  const std::vector<float>&leads = calibration.lead, &right = calibration.right;
  if (leads.empty()) return 1 / (1 + std::exp(-lead));
  const auto above = std::upper_bound(leads.begin(), leads.end(), lead);
  if (above == leads.begin()) return right.front();
  if (above == leads.end()) return right.back();
  const size_t i = static_cast<size_t>(above - leads.begin());
  const float t = (lead - leads[i - 1]) / (leads[i] - leads[i - 1]);
  return right[i - 1] + t * (right[i] - right[i - 1]);
}

LabelModel read_label_model(const std::filesystem::path& file) {
  const Json json = parse_json<Json>(read_file(file), file.string());
  if (!json.is_object()) throw model_error(file, "", "is not a JSON object");
  LabelModel model;
  model.part_weights[kSkin] = weights_at(json, "skin", kCueNames, file);
  model.part_weights[kHair] = weights_at(json, "hair", kCueNames, file);
  model.pieces.bare = weights_at(json, "bare", kBareCueNames, file);
  model.pieces.hanging = weights_at(json, "hanging", kHangingCueNames, file);
  model.pieces.head = weights_at(json, "head", kHeadCueNames, file);
  model.pieces.leather = weights_at(json, "leather", kLeatherCueNames, file);
  const Json calibration = json.value("calibration", Json::object());
  for (int k = 0; k < kPartCount; ++k)
    model.calibration[k] = calibration_at(calibration, kPartNames[k], file);
  return model;
}

std::string label_model_json(const LabelModel& model) {
  Json json;
  json["skin"] = json_of(model.part_weights[kSkin], kCueNames);
  json["hair"] = json_of(model.part_weights[kHair], kCueNames);
  json["bare"] = json_of(model.pieces.bare, kBareCueNames);
  json["hanging"] = json_of(model.pieces.hanging, kHangingCueNames);
  json["head"] = json_of(model.pieces.head, kHeadCueNames);
  json["leather"] = json_of(model.pieces.leather, kLeatherCueNames);
  for (int k = 0; k < kPartCount; ++k) {
    Json& knots = json["calibration"][kPartNames[k]] = Json::array();
    const Calibration& stored = model.calibration[k];
    for (size_t i = 0; i < stored.lead.size(); ++i)
      knots.push_back({{"lead", std::round(stored.lead[i] * 1e3f) / 1e3},
                       {"right", std::round(stored.right[i] * 1e4f) / 1e4}});
  }
  return json_text(json, 2) + "\n";
}

const LabelModel& installed_label_model() {
  static const LabelModel model = read_label_model(program_file("assets/label_model.json"));
  return model;
}

}  // namespace ohb::labelling
