// <person> and <people> of plan.xml.
#pragma once

#include <filesystem>
#include <vector>

#include "dataset/model/xml_document.h"
#include "dataset/production/plan.h"

namespace ohb::production {

/// A path of the plan: relative to its folder. Throws InputError if nothing is there, or if it is no file
/// (no folder).
std::filesystem::path plan_path(const XmlDocument& xml, pugi::xml_node node, const char* attribute,
                                bool is_folder);

/// Throws InputError unless `id` is a plain name: letters, digits, '_', '-' and '.', not first.
void expect_plain_name(const XmlDocument& xml, pugi::xml_node node, const std::string& id);
/// Throws InputError unless `split` is train, val or test.
void expect_split(const XmlDocument& xml, pugi::xml_node node, const std::string& split);

/// Everybody whom the plan's <person> and <people> name, sorted by id. Throws InputError.
std::vector<PlanPerson> read_people(const XmlDocument& xml, uint64_t seed);

}  // namespace ohb::production
