#include "tvl/slam/loop_thread.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "tvl/base/check.h"

namespace tvl {
namespace {

LoopUpdate Numbered(int last) {
  LoopUpdate update;
  update.last = last;
  return update;
}

TEST(LoopThread, GivesResultsInOrderFromEitherThread) {
  for (const bool in_background : {false, true}) {
    LoopThread loops(in_background);
    for (int i = 0; i < 20; ++i) loops.Give([i] { return Numbered(i); });
    EXPECT_EQ(loops.pending(), 20U);
    for (int i = 0; i < 20; ++i) EXPECT_EQ(loops.Take().last, i);
    EXPECT_EQ(loops.pending(), 0U);
    EXPECT_THROW(loops.Take(), Error);
  }
}

TEST(LoopThread, WorksInTheBackgroundOnlyIfAsked) {
  for (const bool in_background : {false, true}) {
    LoopThread loops(in_background);
    std::thread::id worker;
    loops.Give([&worker] {
      worker = std::this_thread::get_id();
      return LoopUpdate();
    });
    loops.Take();
    EXPECT_EQ(worker != std::this_thread::get_id(), in_background);
  }
}

TEST(LoopThread, HandsOnWhatTheWorkThrows) {
  LoopThread loops(true);
  loops.Give([]() -> LoopUpdate { throw InputError("no disk"); });
  loops.Give([] { return Numbered(1); });
  EXPECT_THROW(loops.Take(), InputError);
  EXPECT_EQ(loops.Take().last, 1);
}

TEST(LoopThread, EndsWithWorkLeft) {
  std::atomic<int> done{0};
  {
    LoopThread loops(true);
    for (int i = 0; i < 1000; ++i) {
      loops.Give([&done] {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        ++done;
        return LoopUpdate();
      });
    }
  }
  EXPECT_LT(done, 1000);
}

}  // namespace
}  // namespace tvl
