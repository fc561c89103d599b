// Where a dataset keeps what. What is shipped: dataset.xml, splits.xml, humans/<id>/{regions,model,views}.
// What only production needs lies in .ohb and may be removed; then everything is made again.
#pragma once

#include <filesystem>
#include <string>

namespace ohb::production {

struct Layout {
  std::filesystem::path root;

  std::filesystem::path humans() const { return root / "humans"; }
  std::filesystem::path person(const std::string& id) const { return humans() / id; }
  std::filesystem::path regions(const std::string& id) const { return person(id) / "regions"; }
  std::filesystem::path model(const std::string& id) const { return person(id) / "model"; }
  std::filesystem::path views(const std::string& id) const { return person(id) / "views"; }

  std::filesystem::path state() const { return root / ".ohb"; }
  /// One marker a finished unit (units.h).
  std::filesystem::path done(const std::string& id) const { return state() / "done" / id; }
  std::filesystem::path marker(const std::string& id, const std::string& unit) const {
    return done(id) / (unit + ".json");
  }
  std::filesystem::path locks() const { return state() / "locks"; }
  /// What the person's last worker wrote on stderr.
  std::filesystem::path log(const std::string& id) const { return state() / "logs" / (id + ".log"); }
  /// Why the person was given up; there only while that holds.
  std::filesystem::path quarantine(const std::string& id) const {
    return state() / "quarantine" / (id + ".txt");
  }
  std::filesystem::path hashes(const std::string& owner) const {
    return state() / "hashes" / (owner + ".json");
  }
};

/// "view_007.exr"
std::string set_file(int number);
/// "set_007", its unit.
std::string set_unit(int number);

}  // namespace ohb::production
