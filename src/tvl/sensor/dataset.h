// Inputs. KITTI folders, recordings and the simulator look the same from here on.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "tvl/sensor/calibration.h"
#include "tvl/sensor/lidar_model.h"
#include "tvl/sensor/sensor_frame.h"

namespace tvl {

// What is known of the sensors before the first frame.
struct SensorSetup {
  std::string name;  // of the data, for reports
  Calibration calibration;
  LidarModel lidar;
  bool has_camera = false;
  // What the data itself says of motion compensation (a tvl.yaml beside it); empty: nothing.
  std::optional<Deskew> deskew;
  // The default where neither the user, the data nor the first frames decide.
  Deskew default_deskew = Deskew::kNone;
  std::optional<uint64_t> seed;  // of simulated data
  // About the input as a whole (no images, files missing, ...): to be shown to the user once.
  std::vector<std::string> warnings;
  // What was recognised of the recording (topics, order of the points, units), for reports.
  std::vector<std::string> notes;
};

// A stream of frames, in order. Ends with an empty optional.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual const SensorSetup& setup() const = 0;
  // Throws InputError only for data that makes going on pointless; what is wrong with one frame
  // comes as its faults.
  virtual std::optional<SensorFrame> Next() = 0;
};

// Random access to recorded or simulated frames.
// Frame() is const and safe to call from several threads.
class Dataset {
 public:
  virtual ~Dataset() = default;
  virtual const SensorSetup& setup() const = 0;
  virtual size_t size() const = 0;
  // Frame `index` < size(); see FrameSource::Next for errors.
  virtual SensorFrame Frame(size_t index) const = 0;
  // That of frame `index`, without the rest where that can be had.
  virtual Timestamp Stamp(size_t index) const { return Frame(index).stamp; }
  // True poses T_cam0first_cam0k, one a frame, the first the identity; empty if not known.
  virtual std::vector<Rigid3d> Truth_T_first_cam0() const { return {}; }
};

// Frames [begin, end) of a Dataset as a stream; the Dataset must outlive it.
class DatasetSource : public FrameSource {
 public:
  explicit DatasetSource(const Dataset& dataset) : DatasetSource(dataset, 0, dataset.size()) {}
  // end is cut to the size; throws InputError when nothing is left.
  DatasetSource(const Dataset& dataset, size_t begin, size_t end);
  const SensorSetup& setup() const override { return dataset_.setup(); }
  std::optional<SensorFrame> Next() override;

 private:
  const Dataset& dataset_;
  size_t next_, end_;
};

}  // namespace tvl
