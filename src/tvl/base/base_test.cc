#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>

#include "tvl/base/check.h"
#include "tvl/base/index.h"
#include "tvl/base/parallel.h"
#include "tvl/base/rng.h"
#include "tvl/base/time.h"

namespace tvl {
namespace {

TEST(Check, ThrowsWithConditionAndMessage) {
  try {
    TVL_CHECK(1 > 2) << "frame " << 7;
    FAIL() << "did not throw";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("1 > 2"), std::string::npos);
    EXPECT_NE(std::string(e.what()).find("frame 7"), std::string::npos);
  }
  EXPECT_THROW(TVL_CHECK_INPUT(false) << "x", InputError);
  EXPECT_NO_THROW(TVL_CHECK(true) << "never");
}

TEST(Index, IsThePositionAndRefusesNegativeOnes) {
  static_assert(Index(0) == 0);
  EXPECT_EQ(Index(std::numeric_limits<int>::max()), 2147483647u);
  EXPECT_THROW(Index(-1), Error);
}

TEST(Timestamp, KeepsNanosecondsOfLargeStamps) {
  const Timestamp a{1317354879123456789}, b{1317354879123456790};
  EXPECT_TRUE(a < b);
  EXPECT_DOUBLE_EQ(SecondsBetween(a, b), 1e-9);
  EXPECT_EQ(Timestamp::FromSeconds(0.1).ns, 100000000);
}

TEST(Rng, StreamsDifferAndRepeat) {
  Rng a(7, 1), b(7, 1), c(7, 2);
  EXPECT_EQ(a.Next(), b.Next());
  EXPECT_NE(a.Next(), c.Next());
}

TEST(Rng, NormalHasUnitVariance) {
  Rng rng(3);
  double sum = 0.0, sum_sq = 0.0;
  const int n = 100000;
  for (int i = 0; i < n; ++i) {
    const double x = rng.Normal();
    sum += x;
    sum_sq += x * x;
  }
  EXPECT_NEAR(sum / n, 0.0, 0.02);
  EXPECT_NEAR(sum_sq / n, 1.0, 0.03);
}

TEST(Executor, VisitsEveryElementOnce) {
  for (const int threads : {1, 3}) {
    const Executor executor(threads);
    std::vector<std::atomic<int>> seen(1003);
    executor.For(seen.size(), 10, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) ++seen[i];
    });
    for (const auto& s : seen) EXPECT_EQ(s.load(), 1);
  }
}

TEST(Executor, SumIsTheSameToTheBitForAnyThreadCount) {
  const auto sum = [](int threads) {
    return Executor(threads).Sum(100000, 64, 0.0, [](size_t begin, size_t end) {
      double s = 0.0;
      for (size_t i = begin; i < end; ++i) s += std::sin(static_cast<double>(i)) * 1e-3;
      return s;
    });
  };
  EXPECT_EQ(sum(1), sum(2));
  EXPECT_EQ(sum(1), sum(5));
}

TEST(Executor, PassesExceptionsOn) {
  EXPECT_THROW(Executor(2).For(10, 1, [](size_t, size_t) { throw InputError("x"); }), InputError);
  EXPECT_THROW(Executor(0), InputError);
}

}  // namespace
}  // namespace tvl
