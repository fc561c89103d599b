// usage: dump_sample SAMPLE.exr    what the C++ reader makes of a sample, on stdout: for each image a line
// "name width height channels" and its floats.
#include <cstdio>

#include "dataset/model/sample.h"

namespace {

void dump(const std::string& name, const ohb::Image& image) {
  std::printf("%s %d %d %d\n", name.c_str(), image.width_px, image.height_px, image.channels);
  std::fwrite(image.values.data(), sizeof(float), image.values.size(), stdout);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const ohb::Sample sample = ohb::read_sample(argv[1]);
  dump("mask", sample.mask);
  dump("normal", sample.normal);
  dump("diffuse", sample.diffuse);
  dump("roughness", sample.roughness);
  dump("specular", sample.specular);
  dump("sss", sample.sss);
  dump("displacement", sample.displacement);
  dump("classes", sample.classes);
  for (const ohb::SampleLight& light : sample.lights) dump("relit." + light.name, light.radiance);
}
