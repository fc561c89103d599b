#include "learner/parallel_for.h"

namespace ohb::learner {

void openmp_parallel_for(int64_t count, void (*body)(int64_t, void*), void* context) {
#pragma omp parallel for schedule(static) if (count > 1)
  for (int64_t i = 0; i < count; ++i) body(i, context);
}

}  // namespace ohb::learner
