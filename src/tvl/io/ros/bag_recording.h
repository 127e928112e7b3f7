// Bags of ROS 1 and ROS 2 as recordings, without ROS.
#pragma once

#include <string>

#include "tvl/io/recording.h"
#include "tvl/io/ros/bag_file.h"
#include "tvl/io/ros/topic_choice.h"

namespace tvl {

// Reads the index and the stamps; scans and images are read when asked for. Stamps are those of the
// message headers, and messages are ordered by them. Where the clocks of scans and images have
// nothing in common, or a header has no stamp, the time of recording is taken, with a warning.
//
// The camera is the first CameraInfo in the image topic's namespace; T_cam_lidar comes from
// /tf_static by the frame ids of the messages, from /tf where that is not enough and says the same
// all the time. What is missing or cannot be used is left empty, with a warning that says so.
//
// Throws InputError for files that are no bags, and for topics that cannot be chosen.
Recording OpenBag(const std::string& path, const BagOptions& options);

}  // namespace tvl
