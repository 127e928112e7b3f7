// A recording as the readers deliver it: scans and images in the order they were taken, each with
// its own time. Nothing is known here of rings, of sweeps or of which image belongs to which scan.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tvl/base/time.h"
#include "tvl/geometry/camera.h"
#include "tvl/geometry/rigid3.h"
#include "tvl/io/image_file.h"
#include "tvl/sensor/raw_scan.h"
#include "tvl/sensor/sensor_frame.h"

namespace tvl {

struct RawScanRead {
  std::shared_ptr<const RawScan> scan;  // null: unusable, the faults say why
  std::vector<FrameFault> faults;       // name the file, or the bag, topic and message
};

// Const and safe to call from several threads. Bad data never throws once the recording is open.
class ScanStream {
 public:
  virtual ~ScanStream() = default;
  virtual size_t size() const = 0;
  // Empty where the format has none: then none of the scans has one.
  virtual std::optional<Timestamp> Stamp(size_t index) const = 0;
  virtual RawScanRead Read(size_t index) const = 0;
};

class ImageStream {
 public:
  virtual ~ImageStream() = default;
  virtual size_t size() const = 0;
  // Empty where the format has none: then image k is taken with scan k.
  virtual std::optional<Timestamp> Stamp(size_t index) const = 0;
  virtual ImageRead Read(size_t index) const = 0;
};

struct Recording {
  std::string name;                         // for messages and reports
  std::unique_ptr<ScanStream> scans;        // never null
  std::unique_ptr<ImageStream> images;      // null: none
  std::optional<Camera> camera;             // of the images, where the recording says
  std::optional<Rigid3d> T_cam_lidar;       // where the recording says
  std::vector<Rigid3d> truth_T_first_cam0;  // one a scan or empty
  std::vector<std::string> warnings;        // about the recording as a whole
  std::vector<std::string> notes;           // what was recognised: topics, fields, files
};

}  // namespace tvl
