// Parallel loops whose results do not depend on the number of threads: the range is cut into
// chunks of a fixed size, and partial results are combined in the order of the chunks.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

namespace tvl {

// A bounded set of worker threads. Cheap to pass by reference; thread-safe.
class Executor {
 public:
  // At most `threads` threads work on a loop, the caller's included; 1 runs everything inline.
  explicit Executor(int threads = 1);
  ~Executor();
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  int threads() const { return threads_; }

  // Calls body(begin, end) for consecutive chunks of [0, n), each `chunk` long but the last.
  void For(size_t n, size_t chunk, const std::function<void(size_t, size_t)>& body) const;

  // Runs the tasks, side by side if there are threads for it, and waits for all of them.
  void Invoke(const std::vector<std::function<void()>>& tasks) const;

  // Sums body(begin, end) over the chunks in order, starting from `zero`.
  template <typename T, typename Body>
  T Sum(size_t n, size_t chunk, T zero, const Body& body) const {
    const size_t chunks = (n + chunk - 1) / chunk;
    std::vector<T> partial(chunks, zero);
    For(n, chunk, [&](size_t begin, size_t end) { partial[begin / chunk] = body(begin, end); });
    T total = zero;
    for (const T& p : partial) total += p;
    return total;
  }

 private:
  struct Impl;
  int threads_;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tvl
