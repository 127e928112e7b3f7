#include "tvl/io/recorded_dataset.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/io/pairing.h"

namespace tvl {
namespace {

constexpr double kUsualPeriod_s = 0.1;  // of a spinning lidar, where stamps do not tell

// Middle of the times of a scan; the few that stray at either end do not count.
double MiddleOf_s(const LidarScan& scan) {
  std::vector<float> times_s = scan.time_offset_s;
  if (times_s.empty()) return 0.0;
  std::sort(times_s.begin(), times_s.end());
  const size_t tail = times_s.size() / 100;
  return 0.5 * static_cast<double>(times_s[tail] + times_s[times_s.size() - 1 - tail]);
}

std::string Milliseconds(double s) {
  std::ostringstream out;
  out.precision(3);
  out << 1e3 * s << " ms";
  return out.str();
}

}  // namespace

RecordedDataset::RecordedDataset(Recording recording, const RecordedOptions& options)
    : recording_(std::move(recording)) {
  TVL_CHECK(recording_.scans != nullptr);
  TVL_CHECK_INPUT(size() > 0) << recording_.name << ": no scans";
  setup_.name = recording_.name;
  setup_.notes = recording_.notes;
  setup_.warnings = recording_.warnings;
  FindStamps();
  FindLayout(options.hints);
  FindCamera();
  Pair();
  if (!options.require_first_scan) return;
  TVL_CHECK_INPUT(options.first_frame < size())
      << recording_.name << ": no frame " << options.first_frame << ", there are " << size();
  const SensorFrame first = Frame(options.first_frame);
  const FrameFault* fault = FaultOfScan(first.faults);
  TVL_CHECK_INPUT(first.scan != nullptr || fault == nullptr)
      << recording_.name << ": frame " << options.first_frame
      << " has no usable scan to begin with: " << fault->message << "; begin later, e.g. --frames "
      << options.first_frame + 1 << ":, or mend it";
}

void RecordedDataset::FindStamps() {
  for (size_t i = 0; i < size(); ++i) {
    const std::optional<Timestamp> stamp = recording_.scans->Stamp(i);
    stamps_.push_back(stamp ? *stamp
                            : Timestamp::FromSeconds(kUsualPeriod_s * static_cast<double>(i)));
  }
  if (!recording_.scans->Stamp(0)) {
    setup_.warnings.push_back(recording_.name + ": no times: scans are taken to be " +
                              Milliseconds(kUsualPeriod_s) + " apart");
  }
}

void RecordedDataset::FindLayout(LayoutHints hints) {
  constexpr size_t kScans = 3, kTries = 20;
  std::vector<std::shared_ptr<const RawScan>> scans;
  std::vector<ScanSample> samples;
  std::string why;
  for (size_t i = 0; i < std::min(size(), kTries) && scans.size() < kScans; ++i) {
    const RawScanRead read = recording_.scans->Read(i);
    if (why.empty() && !read.faults.empty()) why = ": " + read.faults.front().message;
    if (read.scan == nullptr || read.scan->size() == 0) continue;
    scans.push_back(read.scan);
    samples.push_back({read.scan.get(), stamps_[i]});
  }
  TVL_CHECK_INPUT(!samples.empty()) << recording_.name << ": none of the first "
                                    << std::min(size(), kTries) << " scans is usable" << why;
  hints.period_s = MedianPeriod_s(stamps_, kUsualPeriod_s);
  layout_ = RecogniseLayout(samples, hints);
  std::vector<double> middles_s;
  for (const ScanSample& sample : samples) {
    middles_s.push_back(MiddleOf_s(ApplyLayout(*sample.scan, layout_, sample.stamp)));
  }
  std::sort(middles_s.begin(), middles_s.end());
  middle_s_ = middles_s[middles_s.size() / 2];
  setup_.lidar = layout_.lidar;
  setup_.notes.insert(setup_.notes.end(), layout_.notes.begin(), layout_.notes.end());
  setup_.warnings.insert(setup_.warnings.end(), layout_.warnings.begin(), layout_.warnings.end());
  if (middle_s_ != 0.0) {
    setup_.notes.push_back("the middle of a sweep lies " + Milliseconds(middle_s_) +
                           " after the scan's stamp");
  }
}

void RecordedDataset::FindCamera() {
  if (recording_.images == nullptr || recording_.images->size() == 0) return;
  if (!recording_.camera || !recording_.T_cam_lidar) {
    setup_.warnings.push_back(recording_.name + ": " + std::to_string(recording_.images->size()) +
                              " images are not used: " +
                              (recording_.camera
                                   ? "where the camera sits is not known (extrinsics T_cam_lidar)"
                                   : "the camera's intrinsics are not known") +
                              "; a rig.yaml may tell (--rig)");
    return;
  }
  setup_.has_camera = true;
  setup_.calibration.camera = *recording_.camera;
  setup_.calibration.T_cam_lidar = *recording_.T_cam_lidar;
  setup_.calibration.T_cam0_lidar = *recording_.T_cam_lidar;
  Camera& camera = setup_.calibration.camera;
  for (size_t i = 0; camera.width_px == 0 && i < std::min<size_t>(recording_.images->size(), 20);
       ++i) {
    const cv::Mat image = recording_.images->Read(i).image;
    camera.width_px = image.cols, camera.height_px = image.rows;
  }
}

Timestamp RecordedDataset::MiddleOf(size_t index) const {
  return {stamps_[index].ns + Timestamp::FromSeconds(middle_s_).ns};
}

// Nearest to the middle of the sweep, within half a turn: an image further away belongs to another.
void RecordedDataset::Pair() {
  image_of_.assign(size(), std::nullopt);
  if (!setup_.has_camera) return;
  std::vector<Timestamp> images;
  for (size_t i = 0; i < recording_.images->size(); ++i) {
    const std::optional<Timestamp> stamp = recording_.images->Stamp(i);
    if (stamp) images.push_back(*stamp);
  }
  if (images.size() != recording_.images->size()) {
    for (size_t i = 0; i < std::min(size(), recording_.images->size()); ++i) image_of_[i] = i;
    setup_.notes.push_back("images have no times: image k is taken with scan k");
    return;
  }
  std::vector<Timestamp> middles;
  for (size_t i = 0; i < size(); ++i) middles.push_back(MiddleOf(i));
  const double period_s = MedianPeriod_s(stamps_, kUsualPeriod_s);
  image_of_ = PairImages(middles, images, 0.5 * period_s);
  std::vector<double> after_s;
  for (size_t i = 0; i < size(); ++i) {
    if (image_of_[i]) after_s.push_back(SecondsBetween(middles[i], images[*image_of_[i]]));
  }
  if (after_s.empty()) {
    setup_.warnings.push_back(recording_.name +
                              ": no image was taken within half a sweep of any scan: do both count "
                              "time from the same instant?");
    return;
  }
  std::sort(after_s.begin(), after_s.end());
  setup_.notes.push_back(std::to_string(after_s.size()) + " of " + std::to_string(size()) +
                         " scans have an image, taken " + Milliseconds(after_s.front()) + " to " +
                         Milliseconds(after_s.back()) + " after the middle of the sweep");
}

Timestamp RecordedDataset::Stamp(size_t index) const {
  TVL_CHECK(index < size()) << index << " of " << size();
  return MiddleOf(index);
}

SensorFrame RecordedDataset::Frame(size_t index) const {
  SensorFrame frame;
  frame.id = static_cast<FrameId>(index);
  frame.stamp = Stamp(index);
  const std::string name = "frame " + std::to_string(index);
  RawScanRead read = recording_.scans->Read(index);
  frame.faults = std::move(read.faults);
  if (read.scan != nullptr) {
    LidarScan scan = ApplyLayout(*read.scan, layout_, stamps_[index]);
    for (float& offset_s : scan.time_offset_s) offset_s -= static_cast<float>(middle_s_);
    if (scan.size() > 0) {
      frame.scan = std::make_shared<const LidarScan>(std::move(scan));
    } else {
      frame.faults.push_back({FrameFault::Kind::kEmptyScan, name + ": its scan has no return"});
    }
  }
  if (setup_.has_camera && image_of_[index]) {
    ImageRead image = recording_.images->Read(*image_of_[index]);
    frame.image = image.image;
    const std::optional<Timestamp> taken = recording_.images->Stamp(*image_of_[index]);
    if (taken) frame.image_delay_s = SecondsBetween(frame.stamp, *taken);
    for (FrameFault& fault : image.faults) frame.faults.push_back(std::move(fault));
  } else if (setup_.has_camera) {
    frame.faults.push_back(
        {FrameFault::Kind::kMissingImage, name + ": no image was taken within its sweep"});
  }
  if (index > 0 && stamps_[index] <= stamps_[index - 1]) {
    frame.faults.push_back({FrameFault::Kind::kTimeNotIncreasing,
                            name + ": its scan's time is not after that of the scan before"});
  }
  return frame;
}

}  // namespace tvl
