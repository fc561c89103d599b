// What is left to a network that does not look at the picture.
#pragma once

#include "learner/task.h"

namespace ohb::learner {

/// Losses::map of one value a channel everywhere, the median of the batch's foreground (mask (B, 1, H, W)
/// above one half): less than any value gives that does not depend on the batch, if `balanced` is not asked
/// for. Without a foreground 0. A network whose loss is no less has learnt nothing, as after too large a
/// learning rate.
double constant_map_loss(Task task, const MaterialMaps& truth, const torch::Tensor& mask,
                         bool balanced = false);

}  // namespace ohb::learner
