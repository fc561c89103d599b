// What labelling has learned from labelled people: how much each cue of a face and of a piece counts, and how
// sure a label really is. Fitted by tests/bench/label_robot --fit; stored in assets/label_model.json.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "dataset/labelling/piece_weights.h"
#include "dataset/labelling/start_cues.h"

namespace ohb::labelling {

/// Skin, hair, garment: indices 0 and 1 are those of the classes.
constexpr int kPartCount = 3, kGarment = 2;
using PartValues = std::array<float, kPartCount>;

/// How often labels are right by how much they lead: piecewise linear over the leads (log odds).
struct Calibration {
  std::vector<float> lead, right;
};

struct LabelModel {
  /// log p(part) = weights . cues + constant; the garment's are 0.
  std::array<Cues, kPartCount - 1> part_weights{};
  PieceWeights pieces;
  /// Of garments, shoes apart, that are leather among people like this one: stated, not learned.
  float leather_share = kLeatherShare;
  std::array<Calibration, kPartCount> calibration;  // of labels of skin, hair and garments
};

PartValues part_probability(const LabelModel& model, const Cues& cues);
/// Of a label that leads by `lead` (log odds against all other parts): the probability that it is right.
float calibrated(const Calibration& calibration, float lead);

/// Throws InputError: missing, not JSON, cues that are not these, numbers that are not finite, a calibration
/// that does not ascend or leaves [0,1].
LabelModel read_label_model(const std::filesystem::path& file);
std::string label_model_json(const LabelModel& model);
/// The installed one; read once.
const LabelModel& installed_label_model();

}  // namespace ohb::labelling
