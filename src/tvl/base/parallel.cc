#include "tvl/base/parallel.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "tvl/base/check.h"

namespace tvl {

struct Executor::Impl {
  explicit Impl(int threads) : arena(threads) {}
  tbb::task_arena arena;
};

Executor::Executor(int threads) : threads_(threads) {
  TVL_CHECK_INPUT(threads >= 1) << "threads: must be at least 1, is " << threads;
  if (threads > 1) impl_ = std::make_unique<Impl>(threads);
}

Executor::~Executor() = default;

void Executor::For(size_t n, size_t chunk, const std::function<void(size_t, size_t)>& body) const {
  TVL_CHECK(chunk > 0) << "a chunk holds at least one element";
  const size_t chunks = (n + chunk - 1) / chunk;
  const auto run = [&](size_t c) { body(c * chunk, std::min(n, (c + 1) * chunk)); };
  if (!impl_ || chunks < 2) {
    for (size_t c = 0; c < chunks; ++c) run(c);
    return;
  }
  impl_->arena.execute([&] { tbb::parallel_for(size_t{0}, chunks, run); });
}

void Executor::Invoke(const std::vector<std::function<void()>>& tasks) const {
  For(tasks.size(), 1, [&](size_t begin, size_t) { tasks[begin](); });
}

}  // namespace tvl
