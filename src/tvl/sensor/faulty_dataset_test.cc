#include "tvl/sensor/faulty_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tvl/base/check.h"

namespace tvl {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// 20 frames at 10 Hz, one metre apart along z of camera 0; frame k has k + 1 points.
class GoodDataset : public Dataset {
 public:
  explicit GoodDataset(bool knows_truth = true) : knows_truth_(knows_truth) {
    setup_.name = "good";
    setup_.has_camera = true;
  }
  const SensorSetup& setup() const override { return setup_; }
  size_t size() const override { return 20; }
  SensorFrame Frame(size_t index) const override {
    SensorFrame frame;
    frame.id = static_cast<FrameId>(index);
    frame.stamp = Timestamp::FromSeconds(5.0 + 0.1 * static_cast<double>(index));
    LidarScan scan;
    scan.points.resize(index + 1);
    frame.scan = std::make_shared<LidarScan>(std::move(scan));
    frame.image = cv::Mat(2, 3, CV_8U, cv::Scalar(100));
    if (index == 7) frame.faults.push_back({FrameFault::Kind::kInvalidPoints, "frame 7"});
    return frame;
  }
  std::vector<Rigid3d> Truth_T_first_cam0() const override {
    std::vector<Rigid3d> truth;
    for (int i = 0; knows_truth_ && i < 20; ++i) truth.push_back(Rigid3d::Translation(0, 0, i));
    return truth;
  }

 private:
  bool knows_truth_;
  SensorSetup setup_;
};

FaultyDataset Faulty(const std::string& faults) {
  return FaultyDataset(std::make_unique<GoodDataset>(), ParseFaults(faults));
}

std::vector<size_t> Sources(const FaultyDataset& data) {
  std::vector<size_t> sources;
  for (size_t i = 0; i < data.size(); ++i) sources.push_back(data.SourceOf(i));
  return sources;
}

// Stamps as Frame() says, since the first frame of the good recording, in ms.
std::vector<int> Stamps_ms(const FaultyDataset& data) {
  std::vector<int> stamps;
  for (size_t i = 0; i < data.size(); ++i) {
    const SensorFrame frame = data.Frame(i);
    EXPECT_EQ(frame.stamp, data.Stamp(i));
    EXPECT_EQ(frame.id, static_cast<FrameId>(i));
    stamps.push_back(static_cast<int>(std::lround(1e3 * (frame.stamp.seconds() - 5.0))));
  }
  return stamps;
}

std::vector<int> Regular_ms(size_t count) {
  std::vector<int> stamps;
  for (size_t i = 0; i < count; ++i) stamps.push_back(100 * static_cast<int>(i));
  return stamps;
}

size_t CountFaults(const SensorFrame& frame, FrameFault::Kind kind) {
  size_t count = 0;
  for (const FrameFault& fault : frame.faults) count += fault.kind == kind ? 1 : 0;
  return count;
}

std::string ErrorOf(const std::string& faults, bool knows_truth = true) {
  try {
    FaultyDataset(std::make_unique<GoodDataset>(knows_truth), ParseFaults(faults));
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

TEST(FaultyDataset, WithoutFaultsIsTheRecording) {
  const FaultyDataset data = Faulty("");
  ASSERT_EQ(data.size(), 20U);
  EXPECT_EQ(Stamps_ms(data), Regular_ms(20));
  EXPECT_EQ(data.setup().name, "good");
  EXPECT_EQ(data.Frame(4).scan->size(), 5U);
  EXPECT_EQ(CountFaults(data.Frame(7), FrameFault::Kind::kInvalidPoints), 1U);
  EXPECT_EQ(data.Truth_T_first_cam0()[19].t().z(), 19.0);
}

TEST(FaultyDataset, DroppedFramesAreGoneAndTruthFollows) {
  const FaultyDataset data = Faulty("drop:0,5-6,19");
  EXPECT_THAT(Sources(data), ElementsAre(1, 2, 3, 4, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18));
  EXPECT_EQ(Stamps_ms(data)[4], 700) << "stamps stay right";
  EXPECT_EQ(data.Frame(4).scan->size(), 8U);
  const std::vector<Rigid3d> truth = data.Truth_T_first_cam0();
  ASSERT_EQ(truth.size(), 16U);
  EXPECT_EQ(truth[0].t().z(), 0.0);
  EXPECT_EQ(truth[4].t().z(), 6.0) << "from frame 1, the first delivered";
}

TEST(FaultyDataset, RenumberingHidesWhatIsLost) {
  const FaultyDataset data = Faulty("drop:5-7;renumber");
  EXPECT_EQ(Stamps_ms(data), Regular_ms(17));
  EXPECT_EQ(data.SourceOf(5), 8U);
}

TEST(FaultyDataset, EveryThirdFrame) {
  const FaultyDataset data = Faulty("every:3");
  EXPECT_THAT(Sources(data), ElementsAre(0, 3, 6, 9, 12, 15, 18));
  EXPECT_THAT(Stamps_ms(data), ElementsAre(0, 300, 600, 900, 1200, 1500, 1800));
  EXPECT_EQ(Stamps_ms(Faulty("every:3;renumber")), Regular_ms(7));
}

TEST(FaultyDataset, FramesComeAgain) {
  const FaultyDataset data = Faulty("repeat:2");
  ASSERT_EQ(data.size(), 40U);
  EXPECT_EQ(data.SourceOf(10), 5U);
  EXPECT_EQ(data.SourceOf(11), 5U);
  EXPECT_EQ(Stamps_ms(data)[10], 500);
  EXPECT_EQ(Stamps_ms(data)[11], 550);
  EXPECT_EQ(Stamps_ms(data)[39], 1950);
  EXPECT_EQ(data.Truth_T_first_cam0()[11].t().z(), 5.0);
  EXPECT_EQ(Stamps_ms(Faulty("repeat:2;renumber")), Regular_ms(40));
}

TEST(FaultyDataset, OneFrameIsHeldWhileTimeGoesOn) {
  const FaultyDataset data = Faulty("hold:18,3");
  ASSERT_EQ(data.size(), 23U);
  EXPECT_EQ(Stamps_ms(data), Regular_ms(23));
  const std::vector<size_t> sources = Sources(data);
  EXPECT_THAT(std::vector<size_t>(sources.begin() + 17, sources.end()),
              ElementsAre(17, 18, 18, 18, 18, 19));
}

TEST(FaultyDataset, StampsAreLate) {
  std::vector<int> expected = Regular_ms(20);
  expected[3] += 98;
  EXPECT_EQ(Stamps_ms(Faulty("late:3,0.098")), expected);
  const std::vector<int> odd = Stamps_ms(Faulty("odd:0.09"));
  EXPECT_EQ(odd[4], 400);
  EXPECT_EQ(odd[5], 590);
  EXPECT_EQ(Stamps_ms(Faulty("drop:0;odd:0.09"))[1], 290) << "of the frames delivered";
}

TEST(FaultyDataset, StampsJitter) {
  const std::vector<int> a = Stamps_ms(Faulty("jitter:0.02")), b = Stamps_ms(Faulty("jitter:0.02"));
  const std::vector<int> other = Stamps_ms(Faulty("jitter:0.02,2"));
  EXPECT_EQ(a, b) << "the same draw";
  EXPECT_NE(a, other);
  double sum_sq = 0.0;
  for (size_t i = 0; i < a.size(); ++i) {
    const double error = a[i] - 100.0 * static_cast<double>(i);
    sum_sq += error * error / 20.0;
  }
  EXPECT_GT(std::sqrt(sum_sq), 10.0);
  EXPECT_LT(std::sqrt(sum_sq), 35.0);
}

TEST(FaultyDataset, StampsAreRounded) {
  const FaultyDataset data = Faulty("round:0.25");
  EXPECT_THAT(Stamps_ms(Faulty("round:0.25;drop:6-19")), ElementsAre(0, 0, 250, 250, 500, 500));
  EXPECT_EQ(CountFaults(data.Frame(1), FrameFault::Kind::kTimeNotIncreasing), 1U);
  EXPECT_EQ(CountFaults(data.Frame(2), FrameFault::Kind::kTimeNotIncreasing), 0U);
}

TEST(FaultyDataset, ClockJumps) {
  const std::vector<int> stamps = Stamps_ms(Faulty("clock:10,20"));
  EXPECT_EQ(stamps[9], 900);
  EXPECT_EQ(stamps[10], 21000);
  EXPECT_EQ(stamps[19], 21900);
  const FaultyDataset back = Faulty("clock:10,-3");
  EXPECT_EQ(CountFaults(back.Frame(10), FrameFault::Kind::kTimeNotIncreasing), 1U);
  EXPECT_EQ(CountFaults(back.Frame(11), FrameFault::Kind::kTimeNotIncreasing), 0U);
}

TEST(FaultyDataset, AllStampsAreEqual) { EXPECT_THAT(Stamps_ms(Faulty("equal")), Each(0)); }

TEST(FaultyDataset, NothingIsSeenInABlackout) {
  const FaultyDataset data = Faulty("blackout:6-8");
  ASSERT_EQ(data.size(), 20U);
  for (size_t i = 5; i <= 9; ++i) {
    const SensorFrame frame = data.Frame(i);
    const bool is_blank = i >= 6 && i <= 8;
    EXPECT_EQ(frame.scan == nullptr, is_blank) << i;
    EXPECT_EQ(frame.image.empty(), is_blank) << i;
    EXPECT_EQ(CountFaults(frame, FrameFault::Kind::kEmptyScan), is_blank ? 1U : 0U);
    EXPECT_EQ(CountFaults(frame, FrameFault::Kind::kBlackImage), is_blank ? 1U : 0U);
  }
  EXPECT_EQ(data.Truth_T_first_cam0()[7].t().z(), 7.0);
}

TEST(FaultyDataset, ReappearsElsewhereAfterABlackout) {
  const FaultyDataset data = Faulty("kidnap:6-8,5");
  ASSERT_EQ(data.size(), 15U);
  EXPECT_EQ(data.Frame(8).scan, nullptr);
  EXPECT_EQ(data.SourceOf(9), 14U) << "5 m beyond frame 9";
  EXPECT_EQ(Stamps_ms(data), Regular_ms(15)) << "as if nothing had happened";
  EXPECT_EQ(data.Truth_T_first_cam0()[9].t().z(), 14.0);
  EXPECT_EQ(Faulty("kidnap:6-8,0").size(), 20U);
}

TEST(FaultyDataset, FaultsFollowEachOther) {
  const FaultyDataset data = Faulty("drop:2-3;late:10,0.05;repeat:2;renumber;late:11,0.03");
  EXPECT_EQ(data.size(), 36U);
  EXPECT_EQ(data.SourceOf(16), 10U);
  std::vector<int> expected = Regular_ms(36);
  expected[18] += 30, expected[19] += 30;
  EXPECT_EQ(Stamps_ms(data), expected) << "a frame is late with all its copies";
}

TEST(FaultyDataset, NamesWhatIsWrong) {
  EXPECT_THAT(ErrorOf("lose:3"), HasSubstr("fault 'lose:3': unknown; known: late odd"));
  EXPECT_THAT(ErrorOf("late:3"), HasSubstr("late wants 2 arguments, got 1"));
  EXPECT_THAT(ErrorOf("late:3,x"), HasSubstr("'x'"));
  EXPECT_THAT(ErrorOf("late:20,1"), HasSubstr("frames 20-20 of 20"));
  EXPECT_THAT(ErrorOf("drop"), HasSubstr("drop wants 1 argument"));
  EXPECT_THAT(ErrorOf("drop:5-4"), HasSubstr("A <= B"));
  EXPECT_THAT(ErrorOf("drop:0-19"), HasSubstr("no frame is left"));
  EXPECT_THAT(ErrorOf("equal:1"), HasSubstr("equal wants 0 arguments"));
  EXPECT_THAT(ErrorOf("every:0"), HasSubstr("count"));
  EXPECT_THAT(ErrorOf("round:0"), HasSubstr("a time of 0 s"));
  EXPECT_THAT(ErrorOf("kidnap:6-8,15"), HasSubstr("does not come 15 m away"));
  EXPECT_THAT(ErrorOf("kidnap:6-19,0"), HasSubstr("kidnap"));
  EXPECT_THAT(ErrorOf("kidnap:6-8,5", false), HasSubstr("true poses"));
}

}  // namespace
}  // namespace tvl
