#include "learner/unseen.h"

#include <spdlog/spdlog.h>

#include <set>

#include "dataset/model/error.h"

namespace ohb::learner {
namespace {

/// Those of `people` whom none of the networks was trained on; the others are named if they are few.
std::vector<std::string> unseen(const std::vector<std::string>& people, const TrainedOn& trained) {
  std::vector<std::string> found;
  for (const std::string& name : people)
    if (const auto by = trained.find(name); by == trained.end())
      found.push_back(name);
    else
      spdlog::warn("{} is left out: {} was trained on that person", name, fmt::join(by->second, ", "));
  return found;
}

}  // namespace

TrainedOn trained_on(const std::vector<nlohmann::json>& headers) {
  TrainedOn trained;
  for (const nlohmann::json& header : headers)
    for (const auto& name : header.value("trained_on", std::vector<std::string>{}))
      trained[name].push_back(header.at("task").get<std::string>());
  return trained;
}

std::vector<std::string> people_to_judge(const std::vector<std::string>& named, const Dataset& dataset,
                                         const std::vector<nlohmann::json>& headers) {
  const TrainedOn trained = trained_on(headers);
  const std::string folder = dataset.folder.string();
  std::set<std::string> there, held_out;
  for (const Person& person : dataset.people) there.insert(person.name);
  for (const std::string& name : named)
    if (there.count(name) == 0)
      throw InputError(folder, "--person " + name, "nobody of that name is in the dataset",
                       "names are the samples' ohb:human");
  if (!named.empty()) return named;
  for (const nlohmann::json& header : headers)
    for (const auto& name : header.value("held_out", std::vector<std::string>{}))
      if (there.count(name)) held_out.insert(name);
  std::vector<std::string> found = unseen({held_out.begin(), held_out.end()}, trained);
  if (!found.empty()) return found;
  for (const std::string& name : there)
    if (trained.count(name) == 0) found.push_back(name);
  if (found.empty())
    throw InputError(folder, "", "the networks were trained on everybody there",
                     "give other people's samples, or name some with --person: the table will mark them");
  spdlog::warn("nobody whom training held out is in {}: everybody there is evaluated whom it was not done on",
               folder);
  return found;
}

}  // namespace ohb::learner
