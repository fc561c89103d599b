#include "dataset/surface/embree_compat.h"
#include "renderer/render.h"

namespace ohb::renderer {

std::string ray_library_version() {
  return RTC_VERSION_STRING;
}

}  // namespace ohb::renderer
