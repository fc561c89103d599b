// usage: dump_sample SAMPLE.exr    what the C++ reader makes of a sample, on stdout: for each image a line
// "name width height channels" and its floats.
//        dump_sample --fields      dataset/python/openhumanbrdf/fields.json, from the table of a sample's
//        maps
#include <cstdio>
#include <cstring>

#include "dataset/model/json_text.h"
#include "dataset/model/map_table.h"

namespace {

void dump(const std::string& name, const ohb::Image& image) {
  std::printf("%s %d %d %d\n", name.c_str(), image.width_px, image.height_px, image.channels);
  std::fwrite(image.values.data(), sizeof(float), image.values.size(), stdout);
}

std::string fields_json() {
  nlohmann::ordered_json fields;
  for (const ohb::SampleMap& map : ohb::sample_maps())
    fields[map.name] = {{"channels", map.channels}, {"unit", map.unit}, {"meaning", map.meaning}};
  fields["relit"] = {{"channels", {"R", "G", "B"}},
                     {"unit", "radiance"},
                     {"meaning", "of one light: linear Rec. 709, premultiplied by mask, background black"}};
  return ohb::json_text(fields, 1) + "\n";
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  if (std::strcmp(argv[1], "--fields") == 0) return std::fputs(fields_json().c_str(), stdout) < 0;
  const ohb::Sample sample = ohb::read_sample(argv[1]);
  for (const ohb::SampleMap& map : ohb::sample_maps()) dump(map.name, sample.*map.image);
  for (const ohb::SampleLight& light : sample.lights) dump("relit." + light.name, light.radiance);
}
