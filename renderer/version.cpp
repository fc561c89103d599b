#include "renderer/embree_compat.h"
#include "renderer/render.h"

namespace ohb {

std::string ray_library_version() {
  return RTC_VERSION_STRING;
}

}  // namespace ohb
