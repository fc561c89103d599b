// Memory of whole images.
#pragma once

#include <cstddef>

namespace ohb {

/// Asks for large pages (2 MiB instead of 4 KiB) for memory that has not been touched yet, where that pays
/// and the system has them: an image's first use is then not dominated by page faults.
void prefer_large_pages(void* memory, size_t bytes);

}  // namespace ohb
