// Which topics of a bag hold the scans, the images, the camera and the transforms.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "tvl/io/ros/message_store.h"
#include "tvl/io/ros/messages.h"

namespace tvl {

// Names of topics; empty: found by type.
struct BagOptions {
  std::string lidar_topic, image_topic;
};

// Positions among the topics of the bag.
struct TopicChoice {
  size_t lidar = 0;
  std::optional<size_t> image, camera_info;
  std::vector<size_t> static_transforms, moving_transforms;
};

// Of an image topic and its compressed twin the raw one is taken, and image topics without
// CameraInfo give way to those with one. Topics without messages, or of an encoding that is neither
// ROS 1's nor CDR, do not count. Throws InputError beginning with `source` that lists the topics
// where there is no scan, where several topics are left, and for options that name no such topic.
TopicChoice ChooseTopics(const std::vector<MessageTopic>& topics, const BagOptions& options,
                         const std::string& source);

// "/points (sensor_msgs/PointCloud2, 120 messages)".
std::string DescribeTopic(const MessageTopic& topic);

// By its name: the driver or a node has rectified the images.
bool IsRectifiedTopic(const std::string& image_topic);

}  // namespace tvl
