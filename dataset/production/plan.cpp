#include "dataset/production/plan.h"

#include <algorithm>
#include <map>
#include <set>

#include "dataset/commands/render_samples.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/data_files.h"
#include "dataset/model/mix_bits.h"
#include "dataset/production/plan_people.h"

namespace ohb::production {
namespace fs = std::filesystem;
namespace {

constexpr uint64_t kSchema = 1;
constexpr uint64_t kMostSets = 100000;  // of a person
constexpr uint64_t kMostLights = 64;    // of a set
constexpr uint64_t kMostMap_px = 8192;  // as many as `bake` makes

uint64_t count_from(const XmlDocument& xml, pugi::xml_node node, const char* attribute, uint64_t low,
                    uint64_t high, uint64_t otherwise) {
  if (!node.attribute(attribute)) return otherwise;
  const uint64_t value = xml.count(node, attribute, high);
  if (value < low)
    throw xml.error(
        node, std::string(attribute) + "=\"" + std::to_string(value) + "\" is below " + std::to_string(low),
        "give " + std::to_string(low) + " to " + std::to_string(high));
  return value;
}

bool is_environment(const fs::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension == ".exr" || extension == ".hdr";
}

EnvironmentPool read_pool(const XmlDocument& xml, pugi::xml_node node, uint64_t seed) {
  xml.expect_attributes(node, {"id", "folder", "split", "train"});
  xml.expect_children(node, {});
  EnvironmentPool pool;
  pool.id = xml.text(node, "id");
  expect_plain_name(xml, node, pool.id);
  fs::path folder = plan_path(xml, node, "folder", true);
  if (fs::exists(folder / "envmaps.xml")) folder /= "envmaps";  // a library of `environments`
  const std::string split = xml.text_or(node, "split", "");
  if (!split.empty() && split != "hash") expect_split(xml, node, split);
  if ((split == "hash") != !node.attribute("train").empty())
    throw xml.error(node, "split=\"hash\" and train go together", "give both, or neither");
  const double train = split == "hash" ? xml.number(node, "train", 0, 1) : 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const fs::path& file = entry.path();
    if (file.filename().string()[0] == '.' || !entry.is_regular_file() || !is_environment(file)) continue;
    PlanEnvironment environment{file.stem().string(), file, split};
    if (split == "hash")
      environment.split =
          share_of_hash(hash_of_text("environment/" + std::to_string(seed) + "/" + environment.name)) < train
              ? "train"
              : "test";
    pool.environments.push_back(std::move(environment));
  }
  if (pool.environments.empty())
    throw xml.error(node, folder.string() + " holds no environment", "put .exr or .hdr files there");
  std::sort(pool.environments.begin(), pool.environments.end(),
            [](const PlanEnvironment& a, const PlanEnvironment& b) { return a.name < b.name; });
  return pool;
}

void read_pools(const XmlDocument& xml, Plan& plan) {
  std::set<std::string> ids;
  std::map<std::string, fs::path> files;
  for (const pugi::xml_node& node : xml.root().children("environments")) {
    plan.pools.push_back(read_pool(xml, node, plan.seed));
    if (!ids.insert(plan.pools.back().id).second)
      throw xml.error(node, "a second <environments id=\"" + plan.pools.back().id + "\">",
                      "give each an id of its own");
    for (const PlanEnvironment& environment : plan.pools.back().environments)
      if (const auto [found, is_new] = files.emplace(environment.name, environment.file); !is_new)
        throw xml.error(node, environment.file.string() + " and " + found->second.string() + " have one name",
                        "rename one: the parts of a sample are named by them");
  }
}

renderer::PointLight read_point(const XmlDocument& xml, pugi::xml_node node, size_t index) {
  xml.expect_attributes(node, {"x_cm", "y_cm", "z_cm", "intensity"});
  xml.expect_children(node, {});
  const auto coordinate = [&](const char* name) {
    return static_cast<float>(xml.number(node, name, -1e5, 1e5));
  };
  return {"point" + std::to_string(index),
          {coordinate("x_cm"), coordinate("y_cm"), coordinate("z_cm")},
          static_cast<float>(xml.number(node, "intensity", 0, 1e9))};
}

/// How many environments of that pool the split may draw.
size_t drawable(const EnvironmentPool& pool, const std::string& split) {
  return static_cast<size_t>(
      std::count_if(pool.environments.begin(), pool.environments.end(),
                    [&](const PlanEnvironment& e) { return e.split.empty() || e.split == split; }));
}

void read_lights(const XmlDocument& xml, pugi::xml_node node, const Plan& plan, ViewSet& views) {
  for (const pugi::xml_node& light : node.children("lights")) {
    xml.expect_attributes(light, {"from", "count"});
    xml.expect_children(light, {});
    LightDraw draw{xml.text(light, "from"),
                   static_cast<int>(count_from(xml, light, "count", 1, kMostLights, 1))};
    const auto pool = std::find_if(plan.pools.begin(), plan.pools.end(),
                                   [&](const EnvironmentPool& p) { return p.id == draw.pool; });
    if (pool == plan.pools.end())
      throw xml.error(light, "from=\"" + draw.pool + "\" is the id of no <environments>",
                      "add <environments id=\"" + draw.pool + "\" folder=\"...\"/>, or correct the id");
    for (const LightDraw& other : views.lights)
      if (other.pool == draw.pool)
        throw xml.error(light, "a second draw from '" + draw.pool + "'", "raise the count of the first");
    if (const size_t there = drawable(*pool, views.split); there < static_cast<size_t>(draw.count))
      throw xml.error(light,
                      std::to_string(draw.count) + " different environments are drawn, and '" + draw.pool +
                          "' has " + std::to_string(there) + " for split '" + views.split + "'",
                      "lower the count or add environments");
    views.lights.push_back(std::move(draw));
  }
  for (const pugi::xml_node& point : node.children("point"))
    views.points.push_back(read_point(xml, point, views.points.size()));
  if (views.lights.empty() && views.points.empty())
    throw xml.error(node, "there is no light", "add <lights from=\"...\" count=\"1\"/> or <point .../>");
}

ViewSet read_views(const XmlDocument& xml, pugi::xml_node node, const Plan& plan) {
  xml.expect_attributes(node, {"split", "count", "repeat", "size_px", "spp", "error", "max_spp", "bounces",
                               "subsurface", "model"});
  xml.expect_children(node, {"lights", "point"});
  ViewSet views;
  views.split = xml.text(node, "split");
  expect_split(xml, node, views.split);
  views.view_count = static_cast<int>(count_from(xml, node, "count", 1, kMostSets, 1));
  views.repeat = static_cast<int>(count_from(xml, node, "repeat", 1, kMostSets, 1));
  if (static_cast<uint64_t>(views.view_count) * static_cast<uint64_t>(views.repeat) > kMostSets)
    throw xml.error(node, "count times repeat is above " + std::to_string(kMostSets), "lower one");
  views.size_px = static_cast<int>(count_from(xml, node, "size_px", 1, 16384, 512));
  views.max_bounces = static_cast<int>(count_from(xml, node, "bounces", 0, 1024, 32));
  if (node.attribute("spp") && node.attribute("error"))
    throw xml.error(node, "has both spp and error", "keep one");
  views.spp = static_cast<int>(count_from(xml, node, "spp", 1, 1 << 24, 64));
  if (node.attribute("max_spp") && !node.attribute("error"))
    throw xml.error(node, "max_spp is for an error goal", "add error=\"...\", or write spp");
  if (node.attribute("error"))
    views.goal = renderer::ErrorGoal{
        xml.number(node, "error", 1e-4, 1),
        static_cast<int>(count_from(xml, node, "max_spp", 16, 1 << 24, renderer::ErrorGoal().max_spp))};
  const std::string subsurface = xml.text_or(node, "subsurface", "walk"),
                    model = xml.text_or(node, "model", "v1");
  if (subsurface != "walk" && subsurface != "diffuse")
    throw xml.error(node, "subsurface=\"" + subsurface + "\" is not known", "write walk or diffuse");
  if (model != "v1" && model != "v2")
    throw xml.error(node, "model=\"" + model + "\" is not known", "write v1 or v2");
  views.subsurface = subsurface == "walk";
  views.shading = model == "v2" ? renderer::ShadingModel::kV2 : renderer::ShadingModel::kV1;
  read_lights(xml, node, plan, views);
  return views;
}

MaterialTable read_materials(const XmlDocument& xml) {
  const pugi::xml_node node = xml.root().child("materials");
  if (!node) return read_material_table(program_file("assets/materials.xml"));
  if (node.next_sibling("materials"))
    throw xml.error(node.next_sibling("materials"), "a second <materials>", "keep one");
  if (!node.attribute("file")) return read_material_table(xml, node);
  xml.expect_attributes(node, {"file"});
  xml.expect_children(node, {});
  return read_material_table(plan_path(xml, node, "file", false));
}

void read_maps(const XmlDocument& xml, Plan& plan) {
  const pugi::xml_node node = xml.root().child("maps");
  if (!node) return;
  if (node.next_sibling("maps")) throw xml.error(node.next_sibling("maps"), "a second <maps>", "keep one");
  xml.expect_attributes(node, {"size_px"});
  xml.expect_children(node, {});
  plan.map_px = static_cast<int>(xml.count(node, "size_px", kMostMap_px));
  if (plan.map_px < 1)
    throw xml.error(node, "size_px=\"0\" is below 1", "leave <maps> out for the pictures' own size");
}

void check_splits(const XmlDocument& xml, const Plan& plan) {
  for (const PlanPerson& person : plan.people)
    if (std::none_of(plan.views.begin(), plan.views.end(),
                     [&](const ViewSet& v) { return v.split == person.split; }))
      throw xml.error(xml.root(),
                      "person '" + person.id + "' is of split '" + person.split + "', which has no views",
                      "add <views split=\"" + person.split + "\" ...>");
}

/// The `count` environments of the pool that this key ranks first.
void draw(const EnvironmentPool& pool, const std::string& split, int count, uint64_t key,
          std::vector<const PlanEnvironment*>& drawn) {
  std::vector<std::pair<uint64_t, const PlanEnvironment*>> ranked;
  for (const PlanEnvironment& environment : pool.environments)
    if (environment.split.empty() || environment.split == split)
      ranked.emplace_back(mix_bits(key ^ hash_of_text(environment.name)), &environment);
  std::partial_sort(ranked.begin(), ranked.begin() + count, ranked.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first : a.second->name < b.second->name;
  });
  for (int i = 0; i < count; ++i) drawn.push_back(ranked[static_cast<size_t>(i)].second);
}

}  // namespace

uint64_t hash_of_text(const std::string& text) {
  uint64_t hash = 0xcbf29ce484222325ull;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ull;
  return mix_bits(hash);
}

double share_of_hash(uint64_t hash) {
  return static_cast<double>(hash >> 11) * 0x1p-53;
}

const ViewSet& Plan::views_of(const PlanPerson& person) const {
  return *std::find_if(views.begin(), views.end(), [&](const ViewSet& v) { return v.split == person.split; });
}

const PlanPerson& Plan::person(const std::string& id) const {
  for (const PlanPerson& person : people)
    if (person.id == id) return person;
  throw InputError(file.string(), "", "has no person '" + id + "'", "run the command again");
}

size_t Plan::set_count() const {
  size_t count = 0;
  for (const PlanPerson& person : people) count += static_cast<size_t>(views_of(person).set_count());
  return count;
}

Plan read_plan(const fs::path& file) {
  const XmlDocument xml(file, "plan");
  xml.expect_attributes(xml.root(), {"schema", "name", "seed"});
  xml.expect_children(xml.root(), {"materials", "maps", "person", "people", "environments", "views"});
  if (const uint64_t schema = xml.count(xml.root(), "schema", 1000000); schema != kSchema)
    throw xml.error(xml.root(),
                    "schema=\"" + std::to_string(schema) + "\" is not known; this version reads 1",
                    schema > kSchema ? "use the version that the plan is for" : "write schema=\"1\"");
  Plan plan;
  plan.file = file;
  plan.sha256 = sha256_of_file(file);
  plan.name = xml.text(xml.root(), "name");
  expect_plain_name(xml, xml.root(), plan.name);
  plan.seed = xml.root().attribute("seed") ? xml.count(xml.root(), "seed", ~uint64_t{0}) : 1;
  plan.materials = read_materials(xml);
  read_maps(xml, plan);
  plan.people = read_people(xml, plan.seed);
  read_pools(xml, plan);
  std::set<std::string> splits;
  for (const pugi::xml_node& node : xml.root().children("views")) {
    plan.views.push_back(read_views(xml, node, plan));
    if (!splits.insert(plan.views.back().split).second)
      throw xml.error(node, "a second <views split=\"" + plan.views.back().split + "\">", "keep one");
  }
  check_splits(xml, plan);
  return plan;
}

std::vector<PlannedSet> sets_of(const Plan& plan, const PlanPerson& person) {
  const ViewSet& views = plan.views_of(person);
  std::vector<PlannedSet> sets;
  for (int k = 0; k < views.set_count(); ++k) {
    PlannedSet set;
    set.number = k;
    set.view = k / views.repeat;
    const std::string key = std::to_string(plan.seed) + "/" + person.id + "/" + std::to_string(k) + "/";
    std::string names;
    for (const LightDraw& lights : views.lights) {
      const auto pool = std::find_if(plan.pools.begin(), plan.pools.end(),
                                     [&](const EnvironmentPool& p) { return p.id == lights.pool; });
      draw(*pool, person.split, lights.count, hash_of_text("light/" + key + pool->id), set.environments);
    }
    for (const PlanEnvironment* environment : set.environments) names.append(environment->name).append("/");
    set.seed = hash_of_text(std::string("seed/" OHB_VERSION "/").append(key).append(names));
    sets.push_back(std::move(set));
  }
  return sets;
}

}  // namespace ohb::production
