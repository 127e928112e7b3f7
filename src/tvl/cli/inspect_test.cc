#include "tvl/cli/inspect.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace tvl {
namespace {

// Three frames at 10 Hz, the second without a scan and stamped too early.
class FaultyDataset : public Dataset {
 public:
  explicit FaultyDataset(size_t bad_frame) : bad_frame_(bad_frame) {}
  const SensorSetup& setup() const override { return setup_; }
  size_t size() const override { return 3; }
  SensorFrame Frame(size_t index) const override {
    SensorFrame frame;
    frame.stamp = Timestamp::FromSeconds(0.1 * static_cast<double>(index));
    if (index == bad_frame_) {
      frame.faults.push_back({FrameFault::Kind::kEmptyScan, "1.bin: no points"});
      return frame;
    }
    auto scan = std::make_shared<LidarScan>();
    for (int i = 0; i <= 20; ++i) {  // two and a half turns
      const float a = static_cast<float>(i) * 0.785398F + 0.1F;
      scan->points.emplace_back(std::cos(a), std::sin(a), 0.0F);
    }
    frame.scan = scan;
    return frame;
  }

 private:
  SensorSetup setup_;
  size_t bad_frame_;
};

TEST(Inspect, CountsWhatIsThereAndWhatIsWrong) {
  const FaultyDataset dataset(1);
  const InspectReport report = Inspect(dataset, Executor(2));
  EXPECT_EQ(report.frames, 3U);
  EXPECT_EQ(report.scans, 2U);
  EXPECT_EQ(report.images, 0U);
  EXPECT_EQ(report.points.median, 21U);
  EXPECT_EQ(report.rings.max, 2U);
  EXPECT_NEAR(report.rate_hz, 10.0, 1e-6);
  ASSERT_EQ(report.faults.count("empty_scan"), 1U);
  EXPECT_EQ(report.faults.at("empty_scan").count, 1U);
  EXPECT_TRUE(report.usable);
  std::ostringstream text;
  PrintReport(dataset, report, text);
  EXPECT_THAT(text.str(), testing::HasSubstr("1.bin: no points"));
}

TEST(Inspect, ABadFirstScanIsNotUsable) {
  const FaultyDataset dataset(0);
  EXPECT_FALSE(Inspect(dataset, Executor(1)).usable);
}

}  // namespace
}  // namespace tvl
