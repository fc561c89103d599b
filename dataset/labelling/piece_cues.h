// What a piece of the surface as a whole shows of its class: whether skin is bare skin or cloth of its
// colour, whether hair hangs there or a garment of its colour, whether a garment is leather.
#pragma once

#include <array>
#include <vector>

#include "dataset/labelling/garments.h"
#include "dataset/labelling/piece_weights.h"

namespace ohb::labelling {

/// One question of fact about a piece; nothing if it does not arise.
struct PieceCues {
  bool may_be_hair = false;  // it was found as hair, touches hair, or lies on the head
  BareCues bare{};           // of what was found as skin
  HangingCues hanging{};     // where it may be hair, below the head
  HeadCues head{};           // where it may be hair, on the head
  LeatherCues leather{};     // if it is a garment
};

/// Of each piece. `part`: kSkin, kHair or kFabric (a garment) of each face.
std::vector<PieceCues> piece_cues(const FaceFeatures& features, const Garments& garments,
                                  const BodyFrame& frame, const std::vector<uint8_t>& part);

/// Probabilities of the classes, by the weights. `leather_share`: how many garments, shoes apart, are
/// leather among people like this one, in (0,1). No look makes leather rarer than kLeastLeather.
ClassValues piece_classes(const Garment& piece, const PieceCues& cues, const PieceWeights& weights,
                          float leather_share);
float log_odds(float share);

}  // namespace ohb::labelling
