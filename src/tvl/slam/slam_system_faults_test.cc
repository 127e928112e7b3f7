// Stamps, repeated and lost scans, starts at speed and blackouts, through the whole system.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "tvl/slam/slam_system.h"
#include "tvl/slam/test_drive.h"

namespace tvl {
namespace {

using synthetic::Drive;
using synthetic::DriveOptions;

// A frame as it is delivered: which of the drive's frames, and with which stamp.
struct Delivery {
  size_t physical = 0;
  double stamp_s = 0.0;
  bool dark = false;  // neither scan nor image
};

struct Played {
  std::vector<Delivery> deliveries;
  std::vector<FrameResult> frames;
  Trajectory trajectory;
};

SlamOptions LidarOnly() {
  SlamOptions options;
  options.use_camera = false;
  options.loops.enabled = false;
  return options;
}

DriveOptions Straight(size_t frames, double speed_m_s, Deskew spin = Deskew::kNone) {
  DriveOptions options;
  options.frames = frames;
  options.speed_m_s = speed_m_s;
  options.sway_m = 0.3;
  options.spin = spin;
  return options;
}

std::vector<Delivery> AsDriven(size_t frames) {
  std::vector<Delivery> deliveries;
  for (size_t k = 0; k < frames; ++k) deliveries.push_back({k, 0.1 * static_cast<double>(k)});
  return deliveries;
}

// As if the frames that are left had been taken one after the other.
std::vector<Delivery> Renumbered(std::vector<Delivery> deliveries) {
  for (size_t i = 0; i < deliveries.size(); ++i) {
    deliveries[i].stamp_s = 0.1 * static_cast<double>(i);
  }
  return deliveries;
}

Played Play(const Drive& drive, const std::vector<Delivery>& deliveries, Deskew deskew) {
  const Executor executor(2);
  SlamSystem system(drive.setup(), deskew, LidarOnly());
  Played played{deliveries, {}, {}};
  for (size_t i = 0; i < deliveries.size(); ++i) {
    SensorFrame frame = drive.Frame(deliveries[i].physical);
    frame.id = static_cast<FrameId>(i);
    frame.stamp = Timestamp::FromSeconds(100.0 + deliveries[i].stamp_s);
    if (deliveries[i].dark) frame.scan = nullptr;
    played.frames.push_back(system.ProcessFrame(frame, executor));
  }
  system.Finish();
  played.trajectory = system.trajectory();
  return played;
}

double Error_m(const Drive& drive, const Played& played, size_t i) {
  const Rigid3d T_true = drive.Truth(played.deliveries.front().physical).Inverse() *
                         drive.Truth(played.deliveries[i].physical);
  return (played.trajectory[i].T_world_lidar.t() - T_true.t()).norm();
}

// No frame that claims to be measured is off; at the end the vehicle is where it is.
void ExpectRight(const Drive& drive, const Played& played, double max_error_m) {
  for (size_t i = 0; i < played.frames.size(); ++i) {
    if (!IsMeasured(played.frames[i].status)) continue;
    EXPECT_LT(Error_m(drive, played, i), max_error_m)
        << "frame " << i << " " << ToString(played.frames[i].status);
  }
  EXPECT_TRUE(IsMeasured(played.frames.back().status));
}

bool HasFault(const FrameResult& frame, FrameFault::Kind kind) {
  return std::any_of(frame.faults.begin(), frame.faults.end(),
                     [&](const FrameFault& fault) { return fault.kind == kind; });
}

class FaultsOn : public ::testing::TestWithParam<Deskew> {};

TEST_P(FaultsOn, StampsThatLieCostNothing) {
  const Drive drive(Straight(36, 9.0, GetParam()));
  using Change = std::function<double(size_t, double)>;
  const std::vector<std::pair<const char*, Change>> changes = {
      {"one 98 ms late", [](size_t k, double s) { return k == 20 ? s + 0.098 : s; }},
      {"odd 90 ms late", [](size_t k, double s) { return k % 2 == 1 ? s + 0.09 : s; }},
      {"rounded", [](size_t, double s) { return 0.25 * std::round(s / 0.25); }},
      {"clock set on", [](size_t k, double s) { return k < 20 ? s : s + 20.0; }},
      {"one far ahead", [](size_t k, double s) { return k == 20 ? s + 1000.0 : s; }},
      {"all equal", [](size_t, double) { return 0.0; }}};
  for (const auto& [name, change] : changes) {
    SCOPED_TRACE(name);
    std::vector<Delivery> deliveries = AsDriven(36);
    for (size_t k = 0; k < 36; ++k) deliveries[k].stamp_s = change(k, deliveries[k].stamp_s);
    ExpectRight(drive, Play(drive, deliveries, GetParam()), 0.1);
  }
}

// The walls of this street are smooth and its boxes few: what two lost scans change cannot be told
// by them. real_faults_test.cc has fewer lost scans, on a real street.
TEST_P(FaultsOn, LostScansAreFoundOut) {
  const Drive drive(Straight(40, 9.0, GetParam()));
  std::vector<Delivery> deliveries = AsDriven(40);
  deliveries.erase(deliveries.begin() + 20, deliveries.begin() + 25);
  ExpectRight(drive, Play(drive, deliveries, GetParam()), 0.15);
  const Played renumbered = Play(drive, Renumbered(deliveries), GetParam());
  ExpectRight(drive, renumbered, 0.15);
  EXPECT_NE(renumbered.frames[20].origin, PoseOrigin::kPrediction);
}

// From the first frame on every scan is followed as if there were no frames between, and those lie
// on the way between the scans.
TEST_P(FaultsOn, FramesWithoutDataBetweenScansCostNothing) {
  const Drive drive(Straight(37, 9.0, GetParam()));
  for (const size_t every : {2u, 3u}) {
    SCOPED_TRACE(every);
    std::vector<Delivery> deliveries = AsDriven(37);
    for (size_t i = 0; i < deliveries.size(); ++i) deliveries[i].dark = i % every != 0;
    const Played played = Play(drive, deliveries, GetParam());
    ExpectRight(drive, played, 0.1);
    for (size_t i = 0; i < deliveries.size(); ++i) {
      EXPECT_EQ(IsMeasured(played.frames[i].status), !deliveries[i].dark) << "frame " << i;
      EXPECT_LT(Error_m(drive, played, i), 0.15) << "frame " << i;
    }
  }
}

TEST_P(FaultsOn, RepeatedScansAreLeftOut) {
  const Drive drive(Straight(20, 9.0, GetParam()));
  std::vector<Delivery> twice;
  for (size_t k = 0; k < 40; ++k) twice.push_back({k / 2, 0.1 * static_cast<double>(k)});
  const Played played = Play(drive, twice, GetParam());
  ExpectRight(drive, played, 0.1);
  for (size_t i = 1; i < 40; i += 2) {
    EXPECT_TRUE(HasFault(played.frames[i], FrameFault::Kind::kRepeatedScan)) << i;
    EXPECT_FALSE(played.frames[i].is_keyframe);
  }
}

TEST_P(FaultsOn, ADriveMayBeginAtSpeed) {
  for (const double speed_m_s : {5.0, 15.0, 28.0}) {
    SCOPED_TRACE(speed_m_s);
    const Drive drive(Straight(8, speed_m_s, GetParam()));
    ExpectRight(drive, Play(drive, AsDriven(8), GetParam()), 0.2);
  }
}

INSTANTIATE_TEST_SUITE_P(CompensatedAndRaw, FaultsOn,
                         ::testing::Values(Deskew::kNone, Deskew::kClockwise));

TEST(Faults, AfterABlackoutThePoseIsFoundAgainAndTheStretchBridged) {
  const Drive drive(Straight(44, 9.0));
  std::vector<Delivery> deliveries = AsDriven(44);
  for (size_t k = 22; k < 28; ++k) deliveries[k].dark = true;
  const Played played = Play(drive, deliveries, Deskew::kNone);
  ExpectRight(drive, played, 0.15);
  for (size_t k = 22; k < 28; ++k) {
    EXPECT_FALSE(IsMeasured(played.frames[k].status)) << k;
    EXPECT_FALSE(played.frames[k].is_keyframe);
    EXPECT_LT(Error_m(drive, played, k), 0.3) << "bridged, frame " << k;
  }
}

// Out of the dark 5 m beside where prediction has it: nothing in between is written.
TEST(Faults, AVehicleThatWasCarriedAwayIsLostAndFoundAgain) {
  const Drive drive(Straight(60, 9.0));
  std::vector<Delivery> deliveries = AsDriven(60);
  for (size_t k = 24; k < 29; ++k) deliveries[k].dark = true;
  deliveries.erase(deliveries.begin() + 29, deliveries.begin() + 35);
  const Played played = Play(drive, Renumbered(deliveries), Deskew::kNone);
  ExpectRight(drive, played, 0.2);
  const auto found = std::find_if(played.frames.begin() + 29, played.frames.end(),
                                  [](const FrameResult& f) { return IsMeasured(f.status); });
  EXPECT_LE(found - (played.frames.begin() + 29), 10);
}

// Scans no reader would hand on, and some that one might: none of them throws, each is a fault of
// its frame, and the drive goes on.
struct OddScan {
  const char* name;
  FrameFault::Kind fault;
  std::function<void(LidarScan*)> spoil;
};

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Column after column, as the sensor fires.
void StoreByColumn(LidarScan* scan) {
  std::stable_sort(scan->points.begin(), scan->points.end(), [](const auto& a, const auto& b) {
    return std::atan2(a.y(), a.x()) < std::atan2(b.y(), b.x());
  });
}

void Shuffle(LidarScan* scan) {
  Rng rng(3);
  for (size_t i = 1; i < scan->size(); ++i) {
    std::swap(scan->points[i],
              scan->points[static_cast<size_t>(rng.Uniform(0.0, static_cast<double>(i)))]);
  }
}

std::vector<OddScan> OddScans() {
  using Kind = FrameFault::Kind;
  return {
      {"stored by column", Kind::kOddScan, StoreByColumn},
      {"shuffled", Kind::kOddScan, Shuffle},
      {"rings beyond the lidar's", Kind::kOddScan,
       [](LidarScan* scan) { scan->ring.assign(scan->size(), 200); }},
      {"too few rings", Kind::kOddScan, [](LidarScan* scan) { scan->ring.assign(5, 1); }},
      {"too many times", Kind::kOddScan,
       [](LidarScan* scan) { scan->time_offset_s.assign(scan->size() + 1, 0.0f); }},
      {"no intensity for most", Kind::kOddScan, [](LidarScan* scan) { scan->intensity.resize(7); }},
      {"times since 1970", Kind::kEmptyScan,
       [](LidarScan* scan) { scan->time_offset_s.assign(scan->size(), 1.3e9f); }},
      {"without points", Kind::kEmptyScan, [](LidarScan* scan) { *scan = LidarScan(); }},
      {"all not a number", Kind::kEmptyScan,
       [](LidarScan* scan) {
         for (Eigen::Vector3f& p : scan->points) p.setConstant(kNan);
       }},
      {"some not a number", Kind::kInvalidPoints,
       [](LidarScan* scan) {
         for (size_t i = 0; i < scan->size(); i += 3) scan->points[i].y() = kNan;
       }},
      {"absurdly far", Kind::kInvalidPoints,
       [](LidarScan* scan) {
         for (size_t i = 0; i < scan->size(); i += 3) scan->points[i].setConstant(1e30f);
       }},
  };
}

TEST(Faults, AnOddScanIsAFaultOfItsFrameAndNothingElse) {
  const Drive drive(Straight(30, 9.0));
  const std::vector<OddScan> odd = OddScans();
  const Executor executor(2);
  SlamSystem system(drive.setup(), Deskew::kNone, LidarOnly());
  Played played{AsDriven(30), {}, {}};
  for (size_t i = 0; i < drive.size(); ++i) {
    SensorFrame frame = drive.Frame(i);
    const size_t k = (i - 6) / 2;
    const bool is_odd = i >= 6 && i % 2 == 0 && k < odd.size();
    auto scan = std::make_shared<LidarScan>(*frame.scan);
    if (is_odd) odd[k].spoil(scan.get());
    frame.scan = scan;
    played.frames.push_back(system.ProcessFrame(frame, executor));
    const FrameResult& result = played.frames.back();
    EXPECT_EQ(result.faults.empty(), !is_odd) << i;
    if (!is_odd) continue;
    EXPECT_TRUE(HasFault(result, odd[k].fault)) << odd[k].name;
    EXPECT_NE(result.faults[0].message.find("frame " + std::to_string(i) + ": "),
              std::string::npos);
    const bool is_lost = FaultOfScan(result.faults) != nullptr;
    EXPECT_EQ(result.status == FrameStatus::kPredicted, is_lost) << odd[k].name;
  }
  system.Finish();
  played.trajectory = system.trajectory();
  ExpectRight(drive, played, 0.15);
}

// What is left of a scan may be next to nothing.
TEST(Faults, AHandfulOfPointsThrowsNothing) {
  const Drive drive(Straight(60, 9.0));
  for (const int rows : {32, 0}) {
    SensorSetup setup = drive.setup();
    if (rows == 0) setup.lidar.beam_elevation_rad.clear();
    SlamSystem system(setup, Deskew::kClockwise, LidarOnly());
    Rng rng(5);
    for (size_t i = 0; i < 60; ++i) {
      SensorFrame frame = drive.Frame(i);
      auto scan = std::make_shared<LidarScan>();
      for (size_t n = 0; n < i % 20 && i > 5; ++n) {
        const float reach_m = static_cast<float>(rng.Uniform(0.0, i % 3 == 0 ? 2.0 : 200.0));
        scan->points.push_back(i % 4 == 0   ? Eigen::Vector3f(0.0f, 0.0f, reach_m)
                               : i % 4 == 1 ? Eigen::Vector3f(reach_m, -0.01f, -1.0f)
                                            : Eigen::Vector3f(Eigen::Vector3f::Random() * reach_m));
        if (i % 5 == 0) scan->ring.push_back(static_cast<uint16_t>(n));
      }
      if (i > 5) frame.scan = scan;
      EXPECT_NO_THROW(system.ProcessFrame(frame, Executor(1))) << i;
    }
    EXPECT_NO_THROW(system.Finish());
  }
}

TEST(Faults, ImagesOfAnotherSizeOrKindAreLeftOut) {
  DriveOptions options = Straight(12, 9.0);
  options.camera = true;
  const Drive drive(options);
  SlamOptions slam = LidarOnly();
  slam.use_camera = true;
  SlamSystem system(drive.setup(), Deskew::kNone, slam);
  for (size_t i = 0; i < drive.size(); ++i) {
    SensorFrame frame = drive.Frame(i);
    if (i == 6) frame.image = frame.image(cv::Rect(0, 0, 300, 100)).clone();
    if (i == 8) frame.image.convertTo(frame.image, CV_32F);
    const FrameResult result = system.ProcessFrame(frame, Executor(2));
    EXPECT_EQ(HasFault(result, FrameFault::Kind::kWrongSizeImage), i == 6);
    EXPECT_EQ(HasFault(result, FrameFault::Kind::kUnreadableImage), i == 8);
    EXPECT_EQ(result.tracking == TrackingStatus::kNoImage, i == 6 || i == 8);
    EXPECT_TRUE(IsMeasured(result.status)) << i;
  }
}

// Nothing of this drive is anywhere near the last scans: the vehicle is lost, says so, and goes on.
TEST(Faults, InAnotherPlaceThePoseIsLostAndTheMapBeginsAnew) {
  const Drive drive(Straight(24, 9.0));
  const Executor executor(2);
  SlamOptions options = LidarOnly();
  options.loops.enabled = true;
  SlamSystem system(drive.setup(), Deskew::kNone, options);
  std::vector<FrameResult> frames;
  for (size_t i = 0; i < 46; ++i) {
    SensorFrame frame = drive.Frame(i % 24);
    frame.id = static_cast<FrameId>(i);
    frame.stamp = Timestamp::FromSeconds(0.1 * static_cast<double>(i));
    if (i >= 24) {  // the street lies across now, and twice as wide
      auto scan = std::make_shared<LidarScan>(*frame.scan);
      for (Eigen::Vector3f& p : scan->points) p = Eigen::Vector3f(p.y(), 1.7f * p.x(), p.z());
      frame.scan = scan;
    }
    frames.push_back(system.ProcessFrame(frame, executor));
  }
  EXPECT_EQ(frames[24].status, FrameStatus::kLost);
  EXPECT_FALSE(frames[24].is_keyframe);
  EXPECT_GT(frames[30].step_covariance(3, 3), frames[20].step_covariance(3, 3));
  EXPECT_TRUE(std::any_of(frames.begin(), frames.end(),
                          [](const FrameResult& f) { return f.map_begins_anew; }));
  EXPECT_TRUE(frames.back().is_keyframe || frames[44].is_keyframe || frames[43].is_keyframe);
  system.Finish();
  EXPECT_EQ(system.loop_fault(), "") << "the first keyframe of the new map is a keyframe, too";
}

}  // namespace
}  // namespace tvl
