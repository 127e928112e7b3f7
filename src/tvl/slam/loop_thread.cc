#include "tvl/slam/loop_thread.h"

#include <condition_variable>
#include <deque>
#include <future>
#include <mutex>
#include <thread>

#include "tvl/base/check.h"

namespace tvl {

struct LoopThread::Impl {
  explicit Impl(bool in_background) {
    if (in_background) thread = std::thread([this] { Run(); });
  }
  ~Impl() {
    {
      const std::lock_guard<std::mutex> lock(mutex);
      stop = true;
    }
    wake.notify_all();
    if (thread.joinable()) thread.join();
  }

  void Run() {
    while (true) {
      std::packaged_task<LoopUpdate()> task;
      {
        std::unique_lock<std::mutex> lock(mutex);
        wake.wait(lock, [this] { return stop || !tasks.empty(); });
        if (stop) return;
        task = std::move(tasks.front());
        tasks.pop_front();
      }
      task();
    }
  }

  std::deque<std::future<LoopUpdate>> results;  // of the giving thread only
  std::deque<std::packaged_task<LoopUpdate()>> tasks;
  bool stop = false;
  std::mutex mutex;  // of tasks and stop
  std::condition_variable wake;
  std::thread thread;
};

LoopThread::LoopThread(bool in_background) : impl_(std::make_unique<Impl>(in_background)) {}
LoopThread::~LoopThread() = default;
LoopThread::LoopThread(LoopThread&&) noexcept = default;
LoopThread& LoopThread::operator=(LoopThread&&) noexcept = default;

void LoopThread::Give(Work work) {
  std::packaged_task<LoopUpdate()> task(std::move(work));
  impl_->results.push_back(task.get_future());
  if (!impl_->thread.joinable()) {
    task();
    return;
  }
  {
    const std::lock_guard<std::mutex> lock(impl_->mutex);
    impl_->tasks.push_back(std::move(task));
  }
  impl_->wake.notify_one();
}

size_t LoopThread::pending() const { return impl_->results.size(); }

LoopUpdate LoopThread::Take() {
  TVL_CHECK(!impl_->results.empty()) << "loop thread: nothing was given";
  std::future<LoopUpdate> result = std::move(impl_->results.front());
  impl_->results.pop_front();
  return result.get();
}

}  // namespace tvl
