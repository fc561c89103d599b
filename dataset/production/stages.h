// The stages of one person before images: label, where the plan gives classes of faces and no regions, and
// bake. Each is one unit whose hash chains on the ones before.
#pragma once

#include <functional>
#include <string>

#include "dataset/production/file_hashes.h"
#include "dataset/production/layout.h"
#include "dataset/production/plan.h"

namespace ohb::production {

/// Called with a unit's name and how long it took, once it is done; not for units that were there.
using UnitDone = std::function<void(const std::string& unit, double seconds)>;

struct BakedPerson {
  std::filesystem::path model;
  std::string identity;  // model_identity of its content
};

/// Labels and bakes a person, or finds it done. A class's material counts only where the person has the
/// class: the others' values are set to 0 in the table that is baked with, so that changing leather leaves
/// alone who wears none. Throws InputError (scan, labels, regions of another scan), TryAgainError (disk full,
/// stopped).
BakedPerson bake_person(const Plan& plan, const PlanPerson& person, const Layout& layout, FileHashes& hashes,
                        const UnitDone& done);

/// The text of materials.xml for a table.
std::string materials_text(const MaterialTable& table);

}  // namespace ohb::production
