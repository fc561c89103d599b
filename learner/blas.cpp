#include "learner/blas.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <ctime>

#include "learner/torch.h"

namespace ohb::learner {
namespace {

constexpr int64_t kEdge = 512;
constexpr double kSlow_gflops = 10;

}  // namespace

double matrix_product_gflops() {
  torch::NoGradGuard no_gradients;
  const torch::Tensor a = torch::ones({kEdge, kEdge}), b = torch::ones({kEdge, kEdge});
  double best_s = 1e9;
  for (int i = 0; i < 3; ++i) {  // the first one starts the threads
    // Processor time of all threads: on a busy machine the clock on the wall would accuse a fast library.
    const std::clock_t start = std::clock();
    torch::mm(a, b);
    best_s = std::min(best_s, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  return 2e-9 * static_cast<double>(kEdge * kEdge * kEdge) / best_s;
}

void warn_of_slow_blas() {
  const double gflops = matrix_product_gflops();
  if (gflops < kSlow_gflops)
    spdlog::warn(
        "matrix products run at {:.1f} GF/s a processor, some 50 times slower than they could: install "
        "libopenblas-dev "
        "and choose it with update-alternatives --config libblas.so.3-x86_64-linux-gnu",
        gflops);
}

}  // namespace ohb::learner
