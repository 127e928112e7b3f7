// Messages with an image: sensor_msgs/Image and sensor_msgs/CompressedImage.
#pragma once

#include <opencv2/core/mat.hpp>

#include "tvl/io/ros/messages.h"

namespace tvl {

struct ImageMessage {
  MessageHeader header;
  std::string encoding;  // or format, as stored
  cv::Mat image;         // 8 or 16 bit, 1 or 3 channels (BGR); its own memory
};

// Raw encodings: mono8, mono16, bgr8, rgb8, bgra8, rgba8, bgr16, rgb16, 8UC1, 8UC3 (as BGR), 8UC4
// (as BGRA), 16UC1, 16UC3, bayer_{rggb,bggr,gbrg,grbg}{8,16}, and 4:2:2 colour (yuv422, uyvy,
// yuv422_yuy2, yuyv). Compressed: JPEG and PNG of up to 64 million pixels. Throws InputError
// beginning with the message's place for anything else.
ImageMessage DecodeImageMessage(MessageKind kind, const StoredMessage& message);

}  // namespace tvl
