#include "renderer/waves.h"

namespace ohb::renderer {

template void trace_paths<false, PrincipledV2>(const PathContext&, Tile&);
template void trace_paths<true, PrincipledV2>(const PathContext&, Tile&);

}  // namespace ohb::renderer
