#include "tvl/io/recorded_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tvl/base/check.h"
#include "tvl/base/units.h"

namespace tvl {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr double kEpoch_s = 1.7e9;

// A lidar of 16 beams in the middle of a round room, stored firing after firing.
RawScan RoundRoom(bool with_times) {
  RawScan scan;
  constexpr int kFirings = 360;
  for (int firing = 0; firing < kFirings; ++firing) {
    const double azimuth = kPi - 2.0 * kPi * (firing + 0.5) / kFirings;
    for (int beam = 0; beam < 16; ++beam) {
      const double elevation = DegToRad(15.0 - 2.0 * beam);
      scan.points.push_back(
          (10.0 * Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), std::tan(elevation)))
              .cast<float>());
      if (with_times) scan.time.push_back(0.1 * (firing + 0.5) / kFirings);
    }
  }
  if (with_times) scan.time_field = "t";
  scan.width = scan.size();
  return scan;
}

struct Scans : ScanStream {
  std::vector<std::optional<Timestamp>> stamps;
  RawScan scan;
  size_t broken = 1000;  // this one cannot be read

  size_t size() const override { return stamps.size(); }
  std::optional<Timestamp> Stamp(size_t index) const override { return stamps[index]; }
  RawScanRead Read(size_t index) const override {
    if (index == broken) return {nullptr, {{FrameFault::Kind::kMissingScan, "scan is broken"}}};
    return {std::make_shared<const RawScan>(scan), {}};
  }
};
struct Images : ImageStream {
  std::vector<std::optional<Timestamp>> stamps;

  size_t size() const override { return stamps.size(); }
  std::optional<Timestamp> Stamp(size_t index) const override { return stamps[index]; }
  // Its brightness tells which it is.
  ImageRead Read(size_t index) const override {
    return {cv::Mat(32, 64, CV_8UC1, cv::Scalar(static_cast<double>(100 + index))), {}};
  }
};

std::vector<std::optional<Timestamp>> Times(double first_s, double period_s, int count) {
  std::vector<std::optional<Timestamp>> out;
  for (int i = 0; i < count; ++i) {
    out.push_back(Timestamp::FromSeconds(kEpoch_s + first_s + period_s * i));
  }
  return out;
}

Recording RecordingOf(bool with_times, double image_s, double image_period_s) {
  Recording recording;
  recording.name = "test";
  auto scans = std::make_unique<Scans>();
  scans->scan = RoundRoom(with_times);
  scans->stamps = Times(0.0, 0.1, 10);
  recording.scans = std::move(scans);
  auto images = std::make_unique<Images>();
  images->stamps = Times(image_s, image_period_s, static_cast<int>(0.95 / image_period_s));
  recording.images = std::move(images);
  recording.camera = Camera{50.0, 50.0, 32.0, 16.0, 0, 0, {}};
  recording.T_cam_lidar = Rigid3d();
  return recording;
}

TEST(RecordedDataset, ScansStampedAtTheirStartArePairedByTheirMiddle) {
  // Sweeps last from 0 to 100 ms; images are taken at 87, 187, ... and 37, 137, ... ms.
  const RecordedDataset dataset(RecordingOf(true, 0.037, 0.05), {});
  const SensorFrame frame = dataset.Frame(2);
  ASSERT_FALSE(frame.image.empty());
  EXPECT_EQ(frame.image.at<uint8_t>(0, 0), 100 + 4);  // at 237 ms, of the sweep about 250 ms
  EXPECT_NEAR(SecondsBetween(Timestamp::FromSeconds(kEpoch_s), frame.stamp), 0.250, 1e-3);
  EXPECT_NEAR(frame.image_delay_s, -0.013, 1e-3);
  ASSERT_EQ(frame.scan->time_offset_s.size(), frame.scan->size());
  EXPECT_NEAR(frame.scan->time_offset_s.front(), -0.05, 1e-3);
  EXPECT_NEAR(frame.scan->time_offset_s.back(), 0.05, 1e-3);
}

TEST(RecordedDataset, WithoutTimesOfThePointsTheOrderGivesThem) {
  const RecordedDataset dataset(RecordingOf(false, 0.0, 0.1), {});
  const SensorFrame frame = dataset.Frame(3);
  EXPECT_NEAR(frame.image_delay_s, 0.0, 1e-3);
  EXPECT_NEAR(frame.scan->time_offset_s.front(), -0.05, 1e-3);
  EXPECT_NEAR(frame.scan->time_offset_s.back(), 0.05, 1e-3);
  EXPECT_EQ(frame.scan->ring.front(), 0);
}

TEST(RecordedDataset, FramesWithoutImageAreStampedWithTheMiddleOfTheSweep) {
  Recording recording = RecordingOf(true, 0.05, 0.1);
  static_cast<Images&>(*recording.images)
      .stamps.erase(static_cast<Images&>(*recording.images).stamps.begin() + 4);
  const RecordedDataset dataset(std::move(recording), {});
  const SensorFrame frame = dataset.Frame(4);
  EXPECT_TRUE(frame.image.empty());
  ASSERT_THAT(frame.faults, SizeIs(1));
  EXPECT_EQ(frame.faults[0].kind, FrameFault::Kind::kMissingImage);
  EXPECT_NEAR(SecondsBetween(Timestamp::FromSeconds(kEpoch_s), frame.stamp), 0.45, 1e-3);
  EXPECT_TRUE(dataset.Frame(5).faults.empty());
}

TEST(RecordedDataset, ImagesOfAnotherClockAreSaid) {
  const RecordedDataset dataset(RecordingOf(true, 500.0, 0.1), {});
  EXPECT_THAT(dataset.setup().warnings, Contains(HasSubstr("no image was taken within")));
  EXPECT_NE(dataset.Frame(0).scan, nullptr);
}

TEST(RecordedDataset, ImagesWithoutExtrinsicsAreNotUsedAndSaid) {
  Recording recording = RecordingOf(true, 0.05, 0.1);
  recording.T_cam_lidar.reset();
  const RecordedDataset dataset(std::move(recording), {});
  EXPECT_FALSE(dataset.setup().has_camera);
  EXPECT_THAT(dataset.setup().warnings, Contains(HasSubstr("where the camera sits is not known")));
}

TEST(RecordedDataset, AScanThatCannotBeReadIsAFaultOfItsFrame) {
  Recording recording = RecordingOf(true, 0.05, 0.1);
  static_cast<Scans&>(*recording.scans).broken = 3;
  const RecordedDataset dataset(std::move(recording), {});
  EXPECT_EQ(dataset.Frame(3).scan, nullptr);
  ASSERT_THAT(dataset.Frame(3).faults, SizeIs(1));
  EXPECT_EQ(dataset.Frame(3).faults[0].kind, FrameFault::Kind::kMissingScan);
}

TEST(RecordedDataset, ARunCannotBeginWithAScanThatCannotBeRead) {
  Recording recording = RecordingOf(true, 0.05, 0.1);
  static_cast<Scans&>(*recording.scans).broken = 0;
  try {
    RecordedDataset(std::move(recording), {});
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("--frames 1:"));
  }
}

TEST(RecordedDataset, ScansWithoutTimesAreATenthOfASecondApart) {
  Recording recording = RecordingOf(true, 0.05, 0.1);
  for (auto& stamp : static_cast<Scans&>(*recording.scans).stamps) stamp.reset();
  recording.images.reset();
  const RecordedDataset dataset(std::move(recording), {});
  EXPECT_NEAR(SecondsBetween(dataset.Stamp(0), dataset.Stamp(4)), 0.4, 1e-9);
  EXPECT_THAT(dataset.setup().warnings, Contains(HasSubstr("no times")));
}

}  // namespace
}  // namespace tvl
