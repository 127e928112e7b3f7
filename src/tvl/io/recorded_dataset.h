// A Recording as a Dataset: what the points of its scans mean, and which image belongs to which
// scan.
//
// A frame is a scan, stamped with the middle of its sweep, and the image nearest to that, which
// says how much later it was taken.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "tvl/io/recording.h"
#include "tvl/lidar/scan_layout.h"
#include "tvl/sensor/dataset.h"

namespace tvl {

struct RecordedOptions {
  LayoutHints hints;
  // The frame a run begins with: its scan must be usable, or nothing can be built on it.
  size_t first_frame = 0;
  bool require_first_scan = true;
};

class RecordedDataset : public Dataset {
 public:
  // Reads the first scans. Throws InputError if none of them is usable.
  RecordedDataset(Recording recording, const RecordedOptions& options);

  const SensorSetup& setup() const override { return setup_; }
  size_t size() const override { return recording_.scans->size(); }
  SensorFrame Frame(size_t index) const override;
  Timestamp Stamp(size_t index) const override;
  std::vector<Rigid3d> Truth_T_first_cam0() const override { return recording_.truth_T_first_cam0; }
  const ScanLayout& layout() const { return layout_; }

 private:
  void FindStamps();
  void FindLayout(LayoutHints hints);
  void FindCamera();
  void Pair();
  Timestamp MiddleOf(size_t index) const;

  Recording recording_;
  std::vector<Timestamp> stamps_;  // of the scans
  ScanLayout layout_;
  double middle_s_ = 0.0;                        // of a sweep, after its scan's stamp
  std::vector<std::optional<size_t>> image_of_;  // one a scan
  SensorSetup setup_;
};

}  // namespace tvl
