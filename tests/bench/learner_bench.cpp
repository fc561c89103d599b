// Speed and memory of the fused rendering loss against batched autograd in the same libtorch.
// Usage: learner_bench [SIZE_PX [THREADS]]; prints one line each and the ratio.
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include "learner/chunked_loss.h"
#include "learner/fused_loss.h"
#include "tests/learner/test_maps.h"

namespace {

using namespace ohb;
using Clock = std::chrono::steady_clock;

/// A line of /proc/self/status, in MB: VmRSS is the memory now, VmHWM its peak.
double status_mb(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind(name + ":", 0) == 0) return std::strtod(line.c_str() + name.size() + 1, nullptr) / 1024;
  return 0;
}

/// The peak starts anew at the memory of now.
void reset_peak() {
  std::ofstream("/proc/self/clear_refs") << "5";
}

double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

struct Measure {
  double wall_s, processor_s, extra_mb, loss;
};

template <typename Loss>
Measure measure(const Loss& loss, MaterialMaps prediction, const MaterialMaps& truth,
                const torch::Tensor& mask, int repeats) {
  require_gradients(prediction);
  const auto lights = training_lights(7);
  Measure best{1e30, 1e30, 0, 0};
  ::malloc_trim(0);  // what earlier runs freed would hide what this one takes
  reset_peak();
  const double before = status_mb("VmRSS");
  for (int i = 0; i < repeats; ++i) {
    for (torch::Tensor* map : tensors_of(prediction)) map->mutable_grad() = torch::Tensor();
    const double processor = processor_seconds();
    const auto start = Clock::now();
    const torch::Tensor value = loss(prediction, truth, mask, lights, shading::Options{});
    value.backward();
    best.wall_s = std::min(best.wall_s, std::chrono::duration<double>(Clock::now() - start).count());
    best.processor_s = std::min(best.processor_s, processor_seconds() - processor);
    best.loss = value.item<double>();
  }
  best.extra_mb = status_mb("VmHWM") - before;
  return best;
}

void print(const char* name, const Measure& m) {
  std::printf("%-28s wall %8.3f s   processor %8.3f s   memory beyond the maps %8.1f MB   loss %.7f\n", name,
              m.wall_s, m.processor_s, m.extra_mb, m.loss);
}

}  // namespace

int main(int argc, char** argv) {
  const int size_px = argc > 1 ? std::atoi(argv[1]) : 512;
  const int threads = argc > 2 ? std::atoi(argv[2]) : 2;
  torch::set_num_threads(threads);
  const MaterialMaps truth = random_maps(1, size_px, size_px, torch::kFloat, 1);
  const MaterialMaps prediction = random_maps(1, size_px, size_px, torch::kFloat, 2);
  const torch::Tensor all = torch::ones({1, 1, size_px, size_px});
  torch::Tensor fifth = torch::zeros_like(all);
  fifth.slice(3, 2 * size_px / 5, 3 * size_px / 5).fill_(1);
  std::printf("37 lights, %d x %d, value and gradient of six maps, %d threads\n", size_px, size_px, threads);
  // Threads and their buffers start here, outside what is measured.
  (void)measure(fused_rendering_loss, random_maps(1, 16, 16, torch::kFloat, 1),
                random_maps(1, 16, 16, torch::kFloat, 2), torch::ones({1, 1, 16, 16}), 1);
  const Measure part = measure(fused_rendering_loss, prediction, truth, fifth, 5);
  print("fused, 20 % foreground", part);
  const Measure fused = measure(fused_rendering_loss, prediction, truth, all, 5);
  print("fused, full frame", fused);
  const auto by_chunks = [](const auto&... arguments) { return chunked_rendering_loss(arguments...); };
  print("chunks of 512 MB, full frame", measure(by_chunks, prediction, truth, all, 1));
  const Measure oracle = measure(oracle_rendering_loss, prediction, truth, all, 1);
  print("autograd, lights in a batch", oracle);
  std::printf("ratio, full frame: wall %.1f, processor %.1f; value differs by %.1e\n",
              oracle.wall_s / fused.wall_s, oracle.processor_s / fused.processor_s,
              std::fabs(oracle.loss - fused.loss) / oracle.loss);
  return 0;
}
