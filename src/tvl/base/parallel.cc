#include "tvl/base/parallel.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "tvl/base/check.h"

#ifdef __SANITIZE_THREAD__
#include <atomic>
#include <thread>
#include <vector>
#endif

namespace tvl {

#ifdef __SANITIZE_THREAD__
// The thread sanitizer does not see how TBB, built without it, hands work from thread to thread:
// there, threads of our own take the chunks.
struct Executor::Impl {
  explicit Impl(int threads) : count(threads) {}
  template <typename Run>
  void For(size_t chunks, const Run& run) const {
    std::atomic<size_t> next{0};
    const auto work = [&] {
      for (size_t c = next++; c < chunks; c = next++) run(c);
    };
    std::vector<std::thread> threads;
    for (int i = 1; i < count; ++i) threads.emplace_back(work);
    work();
    for (std::thread& thread : threads) thread.join();
  }
  int count;
};
#else
struct Executor::Impl {
  explicit Impl(int threads) : arena(threads) {}
  template <typename Run>
  void For(size_t chunks, const Run& run) {
    arena.execute([&] { tbb::parallel_for(size_t{0}, chunks, run); });
  }
  tbb::task_arena arena;
};
#endif

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
  impl_->For(chunks, run);
}

void Executor::Invoke(const std::vector<std::function<void()>>& tasks) const {
  For(tasks.size(), 1, [&](size_t begin, size_t) { tasks[begin](); });
}

}  // namespace tvl
