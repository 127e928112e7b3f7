// A KITTI folder (odometry or raw layout, see kitti_layout.h) as a Dataset.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tvl/io/kitti_layout.h"
#include "tvl/io/velodyne_bin.h"
#include "tvl/lidar/scan_layout.h"
#include "tvl/sensor/dataset.h"

namespace tvl {

struct KittiOptions {
  // 0..3, or -1 for the lowest camera that has images.
  int camera = -1;
  // The frame a run begins with: its scan must be usable, or nothing can be built on it.
  size_t first_frame = 0;
  // Off for looking at broken folders.
  bool require_first_scan = true;
  // How the points are stored is found out from the first scans, and whether they are of a lidar
  // there is a profile of. Empty: they are stored ring after ring by the lidar given.
  std::optional<LayoutHints> recognise;
};

// Frame(k) reads from the disk each time; const and thread-safe. What is wrong with a frame comes
// as its faults. Rings are left empty where points are stored ring after ring: they are recovered
// from the order.
class KittiDataset : public Dataset {
 public:
  // Throws InputError naming the folder, file or frame if the input is unusable from the start.
  KittiDataset(const std::string& folder, const LidarModel& lidar,
               const KittiOptions& options = {});

  const SensorSetup& setup() const override { return setup_; }
  size_t size() const override { return layout_.frames.size(); }
  SensorFrame Frame(size_t index) const override;
  Timestamp Stamp(size_t index) const override { return layout_.frames.at(index).stamp; }
  std::vector<Rigid3d> Truth_T_first_cam0() const override { return layout_.truth_T_first_cam0; }

  const KittiLayout& layout() const { return layout_; }

 private:
  // `turns`: of the azimuth in a whole scan.
  void Use(const ScanLayout& layout, int turns);

  KittiLayout layout_;
  ScanExpectation expectation_;
  // Empty: as stored ring after ring, topmost first, each scan's rings are found where it is used.
  std::optional<ScanLayout> scan_layout_;
  SensorSetup setup_;
};

}  // namespace tvl
