// Whom networks may be judged on.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "learner/data.h"

namespace ohb::learner {

/// Person to the tasks of the networks that were trained on that person.
using TrainedOn = std::map<std::string, std::vector<std::string>>;
TrainedOn trained_on(const std::vector<nlohmann::json>& headers);

/// `named`, or where that is empty those whom training held out and none of the networks was trained on, or
/// where there are none all whom none was trained on; says on the log whom it leaves out.
/// Throws InputError: a name that is not in the dataset; nobody but those trained on.
std::vector<std::string> people_to_judge(const std::vector<std::string>& named, const Dataset& dataset,
                                         const std::vector<nlohmann::json>& headers);

}  // namespace ohb::learner
