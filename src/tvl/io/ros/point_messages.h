// Messages with the points of a scan: sensor_msgs/PointCloud2 and the CustomMsg of Livox's drivers
// (github.com/Livox-SDK/livox_ros_driver2).
#pragma once

#include <string>
#include <vector>

#include "tvl/io/cloud/point_fields.h"
#include "tvl/io/ros/messages.h"
#include "tvl/sensor/raw_scan.h"

namespace tvl {

struct PointsMessage {
  MessageHeader header;
  std::vector<PointField> fields;
  RawScan scan;
};

// Throws InputError beginning with the message's place for what contradicts itself.
PointsMessage DecodePointsMessage(MessageKind kind, const StoredMessage& message);

// "x float32, y float32, ring uint16", for people.
std::string DescribeFields(const std::vector<PointField>& fields);

}  // namespace tvl
