#include "renderer/waves.h"

namespace ohb::renderer {

template void trace_paths<false, PrincipledV2>(const PathContext&, Tile&, Vec3f*);
template void trace_paths<true, PrincipledV2>(const PathContext&, Tile&, Vec3f*);

}  // namespace ohb::renderer
