// Loop closing on a real street: what was tuned on simulated drives must hold there. The street is
// driven once only, so passes over it are made of every other frame; what a second drive would add
// (another line, other cars) is not in it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tvl/base/units.h"
#include "tvl/cli/input.h"
#include "tvl/io/test_data.h"
#include "tvl/loop/vocabulary_file.h"
#include "tvl/slam/slam_runner.h"

namespace tvl {
namespace {

// Every frame of about 50 m of street a keyframe, 1 m apart, with the odometry's poses.
struct Street {
  std::vector<Rigid3d> T_odom_lidar;
  std::vector<std::shared_ptr<const KeyframePayload>> payloads;
  Calibration calibration;

  int size() const { return static_cast<int>(payloads.size()); }
  const Rigid3d& T(int frame) const { return T_odom_lidar.at(static_cast<size_t>(frame)); }
  void Add(const Street& other, int frame, const Rigid3d& T_drift) {
    T_odom_lidar.push_back(T_drift * other.T(frame));
    payloads.push_back(other.payloads.at(static_cast<size_t>(frame)));
  }
};

Street DriveStreet(const std::string& folder, bool use_camera) {
  const auto data = OpenInput(folder);
  SlamOptions options;
  options.use_camera = use_camera;
  options.mapping.keyframes.min_translation_m = 1e-6;
  SlamSystem system(data->setup(), Deskew::kClockwise, options);
  const Executor executor(2);
  for (size_t i = 0; i < data->size(); ++i) system.ProcessFrame(data->Frame(i), executor);
  Street street;
  street.calibration = system.setup().calibration;
  for (const Keyframe& keyframe : system.map().keyframes) {
    street.T_odom_lidar.push_back(keyframe.T_odom_lidar);
    street.payloads.push_back(system.map().store->Get(keyframe.id.index));
  }
  return street;
}

Rigid3d Moved(double x_m, double y_m, double yaw_rad) {
  return {ExpSo3({0.0, 0.0, yaw_rad}), Eigen::Vector3d(x_m, y_m, 0.0)};
}

const Rigid3d kDrift(ExpSo3({0.01, -0.006, 0.1}), Eigen::Vector3d(4.0, -3.0, 0.8));

LoopVerdict Verify(const Street& passes, int history, int current, const Rigid3d& T_guess,
                   const LoopVerificationOptions& options) {
  LoopProposal proposal;
  proposal.history = history;
  proposal.current = current;
  const auto cloud = [&](int k) {
    const auto payload = passes.payloads.at(static_cast<size_t>(k));
    return std::shared_ptr<const KeyframeCloud>(payload, &payload->cloud);
  };
  return LoopVerifier(options).Verify(proposal, {passes.T_odom_lidar, cloud, T_guess, 10.0},
                                      Executor(1));
}

class RealLoops : public testing::Test {
 protected:
  void SetUp() override {
    const auto folder = TestDataPath("sequences/kitti360_3000");
    if (!folder) GTEST_SKIP() << "TVL_TEST_DATA is not set: no real street";
    folder_ = *folder;
  }
  std::string folder_;
};

TEST_F(RealLoops, OddFramesAreFoundToBeWhereEvenFramesWere) {
  const Street street = DriveStreet(folder_, false);
  ASSERT_EQ(street.size(), 50);
  Street passes;
  for (int i = 0; i < 50; i += 2) passes.Add(street, i, Rigid3d());
  for (int i = 1; i < 50; i += 2) passes.Add(street, i, kDrift);
  LoopVerificationOptions options;  // keyframes are 2 m apart here
  options.submap.every_keyframe = options.source.every_keyframe = 1;
  options.submap.keyframes_each_way = 12;
  options.source.keyframes_back = 5;
  for (int k = 6; k < 25; k += 6) {
    const Rigid3d T_true = street.T(2 * k).Inverse() * street.T(2 * k + 1);
    const double side = k % 4 == 0 ? 1.0 : -1.0;
    const Rigid3d T_guess = T_true * Moved(side * 7.0, 6.0, side * DegToRad(8.0));
    const LoopVerdict verdict = Verify(passes, k, 25 + k, T_guess, options);
    EXPECT_TRUE(verdict.accepted()) << verdict.reason;
    const Rigid3d error = T_true.Inverse() * verdict.T_history_current;
    EXPECT_LT(error.t().norm(), 0.05);
    EXPECT_LT(error.RotationAngle(), DegToRad(0.15));
    EXPECT_LT(verdict.rms_m, 0.06);
    EXPECT_GT(verdict.overlap - verdict.seen_through, 0.85);
  }
}

// A street is like itself: walls and hedges slide along each other.
TEST_F(RealLoops, AnotherStretchOfTheSameStreetIsRefused) {
  const Street street = DriveStreet(folder_, false);
  ASSERT_EQ(street.size(), 50);
  for (const int current : {44, 48}) {
    Street passes;
    for (int i = 0; i < 22; ++i) passes.Add(street, i, Rigid3d());
    for (int i = current - 10; i <= current; ++i) passes.Add(street, i, kDrift);
    for (const int history : {6, 12, 21}) {
      for (const double yaw_rad : {0.0, kPi}) {
        const LoopVerdict verdict =
            Verify(passes, history, passes.size() - 1, Moved(1.0, 1.0, yaw_rad), {});
        EXPECT_FALSE(verdict.accepted()) << history << " " << current << " " << yaw_rad;
        EXPECT_LT(verdict.overlap - verdict.seen_through, 0.28) << history << " " << current;
      }
    }
  }
}

// Matching by descriptor alone reaches 25 inliers for a third of these.
TEST_F(RealLoops, TheCameraFindsThePoseFromTwoMetresAway) {
  const Street street = DriveStreet(folder_, true);
  ASSERT_EQ(street.size(), 50);
  VisualProposer proposer(std::make_shared<const Vocabulary>(DefaultVocabulary()),
                          street.calibration);
  Street passes;
  for (int i = 0; i < 50; i += 5) passes.Add(street, i, Rigid3d());
  for (int i = 0; i < 50; ++i) passes.Add(street, i, kDrift);
  for (const auto& payload : passes.payloads) proposer.Add(payload->image);
  const auto features = [&](int k) {
    const auto payload = passes.payloads.at(static_cast<size_t>(k));
    return std::shared_ptr<const ImageFeatures>(payload, &payload->image);
  };
  int looked = 0, found = 0;
  for (int frame = 2; frame < 48; ++frame) {
    if (frame % 5 != 2 && frame % 5 != 3) continue;
    const int near = (frame + 2) / 5;  // of the first pass
    ++looked;
    const auto result =
        proposer.Propose(10 + frame, features, [&](int history) { return history == near; });
    for (const LoopProposal& proposal : result.proposals) {
      ++found;
      const Rigid3d T_true = street.T(5 * near).Inverse() * street.T(frame);
      const Rigid3d error = T_true.Inverse() * proposal.T_history_current;
      EXPECT_LT(error.t().norm(), 0.2) << frame;
      EXPECT_LT(error.RotationAngle(), DegToRad(1.0)) << frame;
    }
  }
  EXPECT_EQ(looked, 19);
  EXPECT_GE(found, 17);
}

// Up the street over even frames and back over odd ones, in reverse gear. Scans keep the distortion
// of driving forwards, so nothing is de-skewed.
class ThereAndBack : public FrameSource {
 public:
  explicit ThereAndBack(const Dataset& dataset) : dataset_(dataset) {
    for (size_t i = 0; i < 42; i += 2) order_.push_back(i);
    for (size_t i = 42; i < 50; ++i) order_.push_back(i);  // slowly: nothing turns round at speed
    for (size_t i = 49; i >= 44; --i) order_.push_back(i);
    for (size_t i = 43; i > 1; i -= 2) order_.push_back(i);
  }
  const SensorSetup& setup() const override { return dataset_.setup(); }
  std::optional<SensorFrame> Next() override {
    if (next_ == order_.size()) return std::nullopt;
    SensorFrame frame = dataset_.Frame(order_[next_]);
    frame.id = static_cast<FrameId>(next_);
    frame.stamp.ns = static_cast<int64_t>(next_) * 1500000000;
    ++next_;
    return frame;
  }
  size_t Original(FrameId frame) const { return order_.at(static_cast<size_t>(frame)); }

 private:
  const Dataset& dataset_;
  std::vector<size_t> order_;
  size_t next_ = 0;
};

TEST_F(RealLoops, ADriveThereAndBackClosesAndNoLoopIsFalse) {
  const auto data = OpenInput(folder_);
  const auto street = DriveStreet(folder_, false);
  ThereAndBack source(*data);
  RunOptions options;
  options.slam.use_camera = false;
  options.deskew = Deskew::kNone;
  options.threads = 2;
  const RunResult result = RunSlam(source, options, [](const FrameResult&) { return true; });
  ASSERT_TRUE(result.loop_fault.empty()) << result.loop_fault;
  int accepted = 0;
  for (const LoopRecord& record : result.loops.records) {
    if (record.outcome != LoopOutcome::kAccepted) continue;
    ++accepted;
    const Rigid3d T_true =
        street.T(static_cast<int>(source.Original(record.history_frame))).Inverse() *
        street.T(static_cast<int>(source.Original(record.current_frame)));
    const Rigid3d error = T_true.Inverse() * record.verdict.T_history_current;
    EXPECT_LT(error.t().norm(), 0.25) << record.history_frame << " " << record.current_frame;
    EXPECT_LT(error.RotationAngle(), DegToRad(1.0));
  }
  EXPECT_GE(accepted, 8);
}

}  // namespace
}  // namespace tvl
