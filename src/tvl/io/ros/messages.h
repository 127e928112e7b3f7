// The small messages of ROS: headers, CameraInfo and transforms. Layouts: the .msg files of
// std_msgs, sensor_msgs, geometry_msgs and tf2_msgs.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tvl/base/time.h"
#include "tvl/geometry/camera.h"
#include "tvl/geometry/rigid3.h"
#include "tvl/io/ros/message_store.h"
#include "tvl/io/ros/wire.h"

namespace tvl {

enum class MessageKind {
  kOther,
  kPointCloud2,      // sensor_msgs/PointCloud2
  kLivoxPoints,      // livox_ros_driver/CustomMsg and its successors
  kImage,            // sensor_msgs/Image
  kCompressedImage,  // sensor_msgs/CompressedImage
  kCameraInfo,       // sensor_msgs/CameraInfo
  kTransforms,       // tf2_msgs/TFMessage, tf/tfMessage
  kLidarPackets,     // raw packets of a lidar's driver: known, not read
};

// By the name of ROS 1 (package/Type) or ROS 2 (package/msg/Type).
MessageKind KindOfType(const std::string& type);

// A message with what is needed to read it. The place is for messages to people.
struct StoredMessage {
  MessageBytes bytes;
  MessageEncoding encoding = MessageEncoding::kOther;
  std::string place;  // file, topic and number

  // Of the bytes; it must not outlive this struct.
  WireReader Reader() const { return {bytes.data, bytes.size, encoding, place}; }
};

struct MessageHeader {
  Timestamp stamp;       // zero where the driver does not set it
  std::string frame_id;  // without a leading slash
};

// Bytes of a message that hold the stamp of its header, in either encoding.
inline constexpr size_t kStampBytes = 12;
// Throws InputError, as everything that reads from a message does.
Timestamp ReadStamp(WireReader* reader);
MessageHeader ReadHeader(WireReader* reader);

struct CameraInfoMessage {
  MessageHeader header;
  uint32_t height_px = 0, width_px = 0;  // of the full image, before binning and region of interest
  std::string distortion_model;
  std::vector<double> D;           // coefficients, as the model orders them
  std::array<double, 9> K{}, R{};  // row-major; R turns the camera frame to the rectified one
  std::array<double, 12> P{};      // projection of the rectified camera, row-major
  uint32_t binning_x = 0, binning_y = 0;                         // 0 means 1
  uint32_t roi_x = 0, roi_y = 0, roi_height = 0, roi_width = 0;  // 0 by 0: the full image
};

CameraInfoMessage DecodeCameraInfo(const StoredMessage& message);

// The camera of the images as they are stored. `rectified`: they were rectified, so that P holds
// and there is no distortion. Throws InputError beginning with `source` where the camera is not
// calibrated, the numbers cannot be meant, or the distortion model is not known.
Camera CameraOf(const CameraInfoMessage& info, bool rectified, const std::string& source);

struct FrameTransform {
  std::string parent, child;
  Rigid3d T_parent_child;
};

// Throws InputError, also for rotations that are none.
std::vector<FrameTransform> DecodeTransforms(const StoredMessage& message);

}  // namespace tvl
