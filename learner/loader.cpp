#include "learner/loader.h"

#include <algorithm>
#include <chrono>
#include <numeric>

#include "dataset/model/error.h"
#include "learner/hash.h"

namespace ohb::learner {
namespace {

enum Purpose : uint64_t { kOrder = 1, kLight = 2 };

}  // namespace

Draw draw_at(uint64_t seed, uint64_t position, size_t view_count) {
  const uint64_t epoch = position / view_count;
  std::vector<size_t> order(view_count);
  std::iota(order.begin(), order.end(), size_t{0});
  const uint64_t key = key_of({seed, kOrder, epoch});
  for (size_t i = view_count; i > 1; --i) std::swap(order[i - 1], order[split_mix(key ^ split_mix(i)) % i]);
  return {order[position % view_count], key_of({seed, kLight, position})};
}

Loader::Loader(std::vector<std::filesystem::path> views, Settings settings)
    : views_(std::move(views)), settings_(std::move(settings)) {
  if (views_.empty()) throw InputError("", "--data", "there is no view to read", "give a dataset with views");
  for (int i = 0; i < std::max(1, settings_.threads); ++i) workers_.emplace_back([this] { work(); });
}

Loader::~Loader() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

void Loader::work() {
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] {
      return stopping_ || next_to_read_ < next_to_give_ + static_cast<uint64_t>(settings_.ahead);
    });
    if (stopping_) return;
    const uint64_t number = next_to_read_++, position = position_of(number);
    lock.unlock();
    Result result;
    try {
      const Draw draw = draw_at(settings_.seed, position, views_.size());
      const auto key = [&](uint64_t of_run) { return of_run == 0 ? 0 : key_of({of_run, position}); };
      result.example = read_example(views_[draw.view], draw.light_key, settings_.size_px,
                                    {key(settings_.keys.part), key(settings_.keys.mixture)});
      if (settings_.vary) settings_.vary(result.example, position);
    } catch (...) {
      result.error = std::current_exception();
    }
    lock.lock();
    ready_.emplace(number, std::move(result));
    changed_.notify_all();
  }
}

Example Loader::next() {
  const auto start = std::chrono::steady_clock::now();
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return ready_.count(next_to_give_) > 0; });
  waited_s_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  Result result = std::move(ready_.extract(next_to_give_).mapped());
  ++next_to_give_;
  lock.unlock();
  changed_.notify_all();
  if (result.error) std::rethrow_exception(result.error);
  return std::move(result.example);
}

}  // namespace ohb::learner
