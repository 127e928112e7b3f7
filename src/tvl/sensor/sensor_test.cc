#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/base/units.h"
#include "tvl/sensor/dataset.h"

namespace tvl {
namespace {

class CountingDataset : public Dataset {
 public:
  const SensorSetup& setup() const override { return setup_; }
  size_t size() const override { return 5; }
  SensorFrame Frame(size_t index) const override {
    SensorFrame frame;
    frame.id = static_cast<FrameId>(index);
    return frame;
  }

 private:
  SensorSetup setup_;
};

TEST(DatasetSource, DeliversTheRangeInOrderAndEnds) {
  const CountingDataset dataset;
  DatasetSource source(dataset, 3, 99);
  EXPECT_EQ(source.Next()->id, 3);
  EXPECT_EQ(source.Next()->id, 4);
  EXPECT_FALSE(source.Next().has_value());
  EXPECT_THROW(DatasetSource(dataset, 5, 9), InputError);
}

TEST(FrameFaults, TheOneThatCostTheScanIsFound) {
  using Kind = FrameFault::Kind;
  EXPECT_EQ(FaultOfScan({{Kind::kInvalidPoints, "a"}, {Kind::kBlackImage, "b"}}), nullptr);
  const std::vector<FrameFault> faults = {{Kind::kInvalidPoints, "a"}, {Kind::kOddScan, "b"}};
  EXPECT_EQ(FaultOfScan(faults), &faults[1]);
}

TEST(LidarModel, LargestGapAndOrder) {
  LidarModel model;
  model.beam_elevation_rad = {DegToRad(2.0), DegToRad(1.5), DegToRad(0.5)};
  EXPECT_NEAR(RadToDeg(model.LargestGap_rad()), 1.0, 1e-12);
  EXPECT_NO_THROW(model.Check());
  model.beam_elevation_rad = {DegToRad(1.0), DegToRad(1.5)};
  EXPECT_THROW(model.Check(), InputError);
}

}  // namespace
}  // namespace tvl
