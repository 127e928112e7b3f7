#include "tvl/loop/bev_alignment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <set>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/base/units.h"

namespace tvl {
namespace {

using Points2 = std::vector<Eigen::Vector2f>;

// Walls of a few houses, a point every 0.25 m, in a 60 m square.
Points2 Houses(uint64_t seed) {
  Rng rng(seed);
  Points2 points;
  for (int house = 0; house < 14; ++house) {
    const Eigen::Vector2d corner(rng.Uniform(-30, 25), rng.Uniform(-30, 25));
    const double width = rng.Uniform(4, 10), depth = rng.Uniform(4, 10);
    for (double s = 0.0; s < width; s += 0.25) {
      points.emplace_back((corner + Eigen::Vector2d(s, 0)).cast<float>());
    }
    for (double s = 0.0; s < depth; s += 0.25) {
      points.emplace_back((corner + Eigen::Vector2d(0, s)).cast<float>());
    }
  }
  return points;
}

// The points as seen from (x, y, yaw): p_target = R p_source + t.
Points2 SeenFrom(const Points2& target, double x_m, double y_m, double yaw_rad) {
  const Eigen::Rotation2D<double> R(yaw_rad);
  Points2 source;
  for (const Eigen::Vector2f& p : target) {
    const Eigen::Vector2d moved = R.inverse() * (p.cast<double>() - Eigen::Vector2d(x_m, y_m));
    source.emplace_back(moved.cast<float>());
  }
  return source;
}

TEST(BevAlignment, FindsShiftAndYawFromFarOff) {
  const Points2 target = Houses(1);
  BevSearch search;
  search.radius_m = 12.0;
  search.yaw_window_rad = DegToRad(15.0);
  for (int i = 0; i < 5; ++i) {
    Rng rng(static_cast<uint64_t>(i), 9);
    const double x = rng.Uniform(-11, 11), y = rng.Uniform(-11, 11);
    const double yaw = DegToRad(rng.Uniform(-13, 13));
    const auto peaks = AlignBev(target, SeenFrom(target, x, y, yaw), search, {}, Executor(1));
    ASSERT_FALSE(peaks.empty());
    EXPECT_LT(std::hypot(peaks[0].x_m - x, peaks[0].y_m - y), 0.75) << i;
    EXPECT_LT(std::abs(peaks[0].yaw_rad - yaw), DegToRad(2.1)) << i;
    EXPECT_GT(peaks[0].score, 0.6);
  }
}

TEST(BevAlignment, TriesAllYawsWhenAsked) {
  const Points2 target = Houses(2);
  BevSearch search;
  search.radius_m = 3.0;
  search.yaw_window_rad = kPi;
  const auto peaks = AlignBev(target, SeenFrom(target, 1.0, -2.0, 2.6), search, {}, Executor(1));
  EXPECT_LT(std::abs(std::remainder(peaks[0].yaw_rad - 2.6, 2 * kPi)), DegToRad(2.1));
}

// The score by its definition: occupied cell 2, one beside it 1, of 2 a source cell.
double ScoreByHand(const Points2& target, const Points2& source, const BevPeak& peak) {
  std::set<std::pair<int, int>> occupied, source_cells;
  const auto cell = [](double x) { return static_cast<int>(std::floor(x / 0.5)); };
  for (const auto& p : target) occupied.insert({cell(p.x()), cell(p.y())});
  const Eigen::Matrix2f R = Eigen::Rotation2D<float>(static_cast<float>(peak.yaw_rad)).matrix();
  double sum = 0.0;
  for (const auto& p : source) {
    if (p.norm() > 40.0f) continue;
    if (!source_cells.insert({cell(p.x()), cell(p.y())}).second) continue;
    const Eigen::Vector2f q = R * p;
    const int x = cell(q.x()) + static_cast<int>(std::lround(peak.x_m / 0.5));
    const int y = cell(q.y()) + static_cast<int>(std::lround(peak.y_m / 0.5));
    int weight = 0;
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        if (occupied.count({x + dx, y + dy}) > 0) weight = std::max(weight, dx || dy ? 1 : 2);
      }
    }
    sum += weight;
  }
  return sum / (2.0 * static_cast<double>(source_cells.size()));
}

TEST(BevAlignment, ScoresAreTheirDefinitionAndNoShiftIsBetter) {
  const Points2 target = Houses(3), source = SeenFrom(target, 2.0, 1.0, 0.05);
  BevSearch search;
  search.radius_m = 4.0;
  search.yaw_window_rad = 0.07;
  BevAlignmentOptions options;
  const auto peaks = AlignBev(target, source, search, options, Executor(1));
  ASSERT_FALSE(peaks.empty());
  for (const BevPeak& peak : peaks) {
    EXPECT_NEAR(peak.score, ScoreByHand(target, source, peak), 1e-12);
  }
  for (int k = -2; k <= 2; ++k) {
    for (int x = -8; x <= 8; ++x) {
      for (int y = -8; y <= 8; ++y) {
        const BevPeak other{0.5 * x, 0.5 * y, k * options.yaw_step_rad, 0.0};
        EXPECT_LE(ScoreByHand(target, source, other), peaks[0].score + 1e-12);
      }
    }
  }
}

TEST(BevAlignment, IdenticalRowsGiveSeveralPeaks) {
  Points2 row;
  for (int house = -6; house <= 6; ++house) {
    for (double s = 0.0; s < 3.0; s += 0.25) {
      row.emplace_back(static_cast<float>(6.0 * house + s), 8.0f);
      row.emplace_back(static_cast<float>(6.0 * house), static_cast<float>(8.0 + s));
    }
  }
  BevSearch search;
  search.radius_m = 8.0;
  search.yaw_window_rad = 0.0;
  BevAlignmentOptions options;
  options.range_m = 20.0;
  const auto peaks = AlignBev(row, row, search, options, Executor(1));
  ASSERT_EQ(peaks.size(), 3u);
  EXPECT_NEAR(peaks[1].score, peaks[0].score, 0.05);
  EXPECT_NEAR(std::hypot(peaks[1].x_m - peaks[0].x_m, peaks[1].y_m - peaks[0].y_m), 6.0, 0.1);
}

TEST(BevAlignment, ThreadsChangeNothing) {
  const Points2 target = Houses(4), source = SeenFrom(target, -3.0, 5.0, 0.1);
  const BevSearch search;
  const auto one = AlignBev(target, source, search, {}, Executor(1));
  const auto four = AlignBev(target, source, search, {}, Executor(4));
  ASSERT_EQ(one.size(), four.size());
  for (size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].x_m, four[i].x_m);
    EXPECT_EQ(one[i].yaw_rad, four[i].yaw_rad);
    EXPECT_EQ(one[i].score, four[i].score);
  }
}

TEST(BevAlignment, NothingGivesNothing) {
  EXPECT_TRUE(AlignBev({}, Houses(1), {}, {}, Executor(1)).empty());
  EXPECT_TRUE(AlignBev(Houses(1), {}, {}, {}, Executor(1)).empty());
}

TEST(BevAlignment, OptionsAreNamed) {
  BevAlignmentOptions options;
  options.cell_m = 0.0;
  try {
    options.Check();
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("cell_m"));
  }
}

TEST(AboveGround, SlopesAreGroundAndWallsAreNot) {
  std::vector<Eigen::Vector3f> points;
  std::vector<char> expected;
  for (float x = -10.0f; x < 10.0f; x += 0.5f) {  // a street of 10 degrees
    points.emplace_back(x, 0.0f, 0.176f * x);
    expected.push_back(0);
  }
  for (float z = 1.0f; z < 3.0f; z += 0.5f) {  // a wall on it
    points.emplace_back(4.0f, 0.2f, 0.176f * 4.0f + z);
    expected.push_back(1);
  }
  EXPECT_EQ(AboveGround(points, 0.75), expected);
}

}  // namespace
}  // namespace tvl
