#include "renderer/path_tracer.h"

namespace ohb {

template void trace_path<false, PrincipledV2>(const PathContext&, const Ray&, const Hit&, PathSampler&, Tile&,
                                              Vec3f*);
template void trace_path<true, PrincipledV2>(const PathContext&, const Ray&, const Hit&, PathSampler&, Tile&,
                                             Vec3f*);

}  // namespace ohb
