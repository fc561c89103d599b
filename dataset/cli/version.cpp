#include "dataset/cli/version.h"

#include "dataset/model/error.h"
#include "dataset/model/image.h"
#include "renderer/render.h"

namespace ohb {

std::string version_text() {
  std::string features;
  if (__builtin_cpu_supports("avx2")) features += " AVX2";
  if (__builtin_cpu_supports("fma")) features += " FMA";
  if (__builtin_cpu_supports("avx512f")) features += " AVX-512";
  return "openhumanbrdf " OHB_VERSION "\nOpenImageIO " + image_library_version() + "\nEmbree " +
         renderer::ray_library_version() + "\nprocessor features in use:" + features + "\n";
}

void check_processor() {
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma"))
    throw InputError("", "", "this processor has no AVX2 and FMA, which this build needs",
                     "configure with -DOHB_ARCH=x86-64-v2 and build again");
}

}  // namespace ohb
