// A folder with a plan and what it names: a person's files and environments that nobody opens.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

namespace ohb::production {

class PlanFolder {
 public:
  PlanFolder() {
    char name[] = "/tmp/ohb_plan_XXXXXX";
    folder = mkdtemp(name);
    write("a.obj", "v 0 0 0\n");
    write("a.txt", "0\n");
    for (const char* id : {"p1", "p2", "p3"}) {
      write("people/" + std::string(id) + "/" + id + "_scan.obj", "v 0 0 0\n");
      write("people/" + std::string(id) + "/" + id + "_scan.labels.txt", "0\n");
    }
    for (const char* name : {"dawn", "noon", "dusk", "night"})
      write("env/" + std::string(name) + ".exr", "x");
    write("more/dawn.hdr", "x");
    std::filesystem::create_directories(folder / "empty");
  }
  ~PlanFolder() { std::filesystem::remove_all(folder); }

  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder / name).parent_path());
    std::ofstream(folder / name) << text;
    return folder / name;
  }
  /// <plan> with these elements inside.
  std::filesystem::path plan(const std::string& inside) const {
    return write("plan.xml", "<plan schema=\"1\" name=\"t\">\n" + inside + "\n</plan>\n");
  }

  std::filesystem::path folder;
};

inline const std::string kPerson = R"(<person id="a" scan="a.obj" labels="a.txt" split="train"/>)";
inline const std::string kEnvironments = R"(<environments id="e" folder="env"/>)";
inline const std::string kViews =
    R"(<views split="train" count="3" size_px="8" spp="1"><lights from="e" count="2"/></views>)";

}  // namespace ohb::production
