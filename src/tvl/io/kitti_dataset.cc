#include "tvl/io/kitti_dataset.h"

#include <algorithm>
#include <filesystem>

#include "tvl/base/check.h"
#include "tvl/io/image_file.h"

namespace tvl {
namespace {

using Kind = FrameFault::Kind;

constexpr size_t kPointBytes = 16;

// Median number of points of the files there are; sizes alone tell it.
size_t TypicalPoints(const std::vector<KittiFrameFiles>& frames) {
  std::vector<size_t> counts;
  for (const KittiFrameFiles& frame : frames) {
    std::error_code error;
    const auto bytes = std::filesystem::file_size(frame.scan_path, error);
    if (!frame.scan_path.empty() && !error) counts.push_back(bytes / kPointBytes);
  }
  if (counts.empty()) return 0;
  const auto middle = counts.begin() + static_cast<std::ptrdiff_t>(counts.size() / 2);
  std::nth_element(counts.begin(), middle, counts.end());
  return *middle;
}

// The size most of up to three readable images have: at the beginning, middle and end, so that one
// odd image does not decide. Zero if none can be read.
cv::Size TypicalImageSize(const std::vector<KittiFrameFiles>& frames) {
  std::vector<cv::Size> sizes;
  const size_t n = frames.size();
  for (const size_t begin : {size_t{0}, n / 3, 2 * n / 3}) {
    const size_t end = std::min(begin + std::max<size_t>(n / 3, 1), n);
    for (size_t i = begin; i < end; ++i) {
      if (frames[i].image_path.empty()) continue;
      const ImageRead read = ReadImage(frames[i].image_path, 0, 0);
      if (read.image.empty()) continue;
      sizes.push_back(read.image.size());
      break;
    }
  }
  if (sizes.empty()) return {};
  const bool last_two_agree = sizes.size() == 3 && sizes[1] == sizes[2];
  return last_two_agree ? sizes[1] : sizes[0];
}

void AddFaults(std::vector<FrameFault> from, SensorFrame* frame) {
  for (FrameFault& fault : from) frame->faults.push_back(std::move(fault));
}

// KITTI raw drives and KITTI-360 store each scan as it was measured, from a lidar that spins
// clockwise seen from above; the KITTI odometry benchmark stores motion-compensated scans.
// KITTI-360 in the odometry layout is known by the size of its rectified perspective images.
Deskew DefaultDeskew(bool is_raw_layout, const cv::Size& image) {
  const cv::Size kitti360(1408, 376);
  return is_raw_layout || image == kitti360 ? Deskew::kClockwise : Deskew::kNone;
}

// A scan of a .bin file as it is stored.
RawScan AsStored(const LidarScan& scan) {
  RawScan raw;
  raw.points = scan.points;
  raw.intensity = scan.intensity;
  raw.width = raw.size();
  return raw;
}

struct Recognised {
  ScanLayout layout;
  int turns = 0;  // most of a scan
};

// From the first usable scans. Empty if there are none.
std::optional<Recognised> RecogniseScans(const std::vector<KittiFrameFiles>& frames,
                                         const LayoutHints& hints) {
  constexpr size_t kScans = 3, kTries = 20;
  Recognised out;
  std::vector<RawScan> scans;
  std::vector<ScanSample> samples;
  for (size_t i = 0; i < std::min(frames.size(), kTries) && scans.size() < kScans; ++i) {
    if (frames[i].scan_path.empty()) continue;
    const ScanRead read = ReadVelodyneBin(frames[i].scan_path, ScanExpectation());
    if (read.scan != nullptr) scans.push_back(AsStored(*read.scan));
    out.turns = std::max(out.turns, read.turns);
  }
  for (const RawScan& scan : scans) samples.push_back({&scan, Timestamp()});
  if (samples.empty()) return std::nullopt;
  out.layout = RecogniseLayout(samples, hints);
  return out;
}

// Ring after ring from the topmost is how the stages take scans, as they are.
bool IsPlain(const ScanLayout& layout) {
  return layout.order == ScanOrder::kRingAfterRing && !layout.lowest_first &&
         layout.metres_per_unit == 1.0;
}

SensorSetup SetupOf(const KittiLayout& layout, const LidarModel& lidar) {
  SensorSetup setup;
  setup.name = layout.name;
  setup.lidar = lidar;
  setup.deskew = layout.deskew;
  setup.default_deskew = DefaultDeskew(layout.is_raw, {});
  setup.warnings = layout.warnings;
  setup.calibration = CalibrationWithoutCamera(layout.calibration);
  if (layout.camera < 0) return setup;
  const cv::Size size = TypicalImageSize(layout.frames);
  if (size.empty()) {
    setup.warnings.push_back(layout.folder + ": no image can be read: lidar only");
    return setup;
  }
  setup.has_camera = true;
  setup.default_deskew = DefaultDeskew(layout.is_raw, size);
  setup.calibration = CalibrationOfCamera(layout.calibration, layout.camera);
  Camera& camera = setup.calibration.camera;
  camera.width_px = size.width;
  camera.height_px = size.height;
  if (camera.cx_px < 0.0 || camera.cx_px > size.width || camera.cy_px < 0.0 ||
      camera.cy_px > size.height) {
    setup.warnings.push_back(layout.calibration.source +
                             ": the principal point lies outside of the images: is this their "
                             "calibration?");
  }
  return setup;
}

}  // namespace

KittiDataset::KittiDataset(const std::string& folder, const LidarModel& lidar,
                           const KittiOptions& options)
    : layout_(FindKittiLayout(folder, options.camera)) {
  std::optional<Recognised> recognised;
  if (options.recognise) recognised = RecogniseScans(layout_.frames, *options.recognise);
  setup_ = SetupOf(layout_, recognised ? recognised->layout.lidar : lidar);
  expectation_ = ExpectationFor(setup_.lidar, TypicalPoints(layout_.frames));
  if (recognised) Use(recognised->layout, recognised->turns);
  if (!options.require_first_scan) return;
  TVL_CHECK_INPUT(options.first_frame < size())
      << folder << ": no frame " << options.first_frame << ", there are " << size();
  const SensorFrame first = Frame(options.first_frame);
  const FrameFault* fault = FaultOfScan(first.faults);
  TVL_CHECK_INPUT(fault == nullptr)
      << folder << ": frame " << options.first_frame
      << " has no usable scan to begin with: " << fault->message << "; begin later, e.g. --frames "
      << options.first_frame + 1 << ":, or mend it";
}

void KittiDataset::Use(const ScanLayout& layout, int turns) {
  setup_.notes = layout.notes;
  for (const std::string& warning : layout.warnings) setup_.warnings.push_back(warning);
  if (!IsPlain(layout)) scan_layout_ = layout;
  // Turns tell whether a scan is whole only where it goes all round, and its end only where the
  // lowest ring comes last.
  const bool goes_round = turns + 1 >= expectation_.min_ring_share * expectation_.rings;
  if (scan_layout_ || !goes_round) expectation_.rings = 0;
}

SensorFrame KittiDataset::Frame(size_t index) const {
  TVL_CHECK(index < size()) << index << " of " << size();
  const KittiFrameFiles& files = layout_.frames[index];
  SensorFrame frame;
  frame.id = static_cast<FrameId>(index);
  frame.stamp = files.stamp;
  const std::string name = "frame " + std::to_string(index);
  if (files.scan_path.empty()) {
    frame.faults.push_back(
        {Kind::kMissingScan, name + ": no scan numbered " + std::to_string(files.number)});
  } else {
    ScanRead read = ReadVelodyneBin(files.scan_path, expectation_);
    frame.scan = read.scan;
    if (scan_layout_ && frame.scan != nullptr) {
      frame.scan = std::make_shared<const LidarScan>(
          ApplyLayout(AsStored(*frame.scan), *scan_layout_, frame.stamp));
    }
    AddFaults(std::move(read.faults), &frame);
  }
  if (setup_.has_camera && files.image_path.empty()) {
    frame.faults.push_back(
        {Kind::kMissingImage, name + ": no image numbered " + std::to_string(files.number)});
  } else if (setup_.has_camera) {
    const Camera& camera = setup_.calibration.camera;
    ImageRead read = ReadImage(files.image_path, camera.width_px, camera.height_px);
    frame.image = read.image;
    AddFaults(std::move(read.faults), &frame);
  }
  if (index > 0 && files.stamp <= layout_.frames[index - 1].stamp) {
    frame.faults.push_back(
        {Kind::kTimeNotIncreasing, name + ": its time " + std::to_string(files.stamp.seconds()) +
                                       " s is not after that of the frame before"});
  }
  return frame;
}

}  // namespace tvl
