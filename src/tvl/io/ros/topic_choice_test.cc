#include "tvl/io/ros/topic_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/base/check.h"

namespace tvl {
namespace {

using testing::HasSubstr;

MessageTopic Topic(const std::string& name, const std::string& type, uint64_t count = 5) {
  return {name, "sensor_msgs/msg/" + type, MessageEncoding::kCdr, count};
}

std::string TextOfError(const std::vector<MessageTopic>& topics, const BagOptions& options) {
  try {
    ChooseTopics(topics, options, "a.bag");
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST(TopicChoice, ImagesWithoutCameraInfoGiveWay) {
  const std::vector<MessageTopic> topics = {
      Topic("/cam/camera_info", "CameraInfo"), Topic("/cam/image/compressed", "CompressedImage"),
      Topic("/debug/image", "Image"), Topic("/empty", "PointCloud2", 0),
      Topic("/points", "PointCloud2")};
  const TopicChoice choice = ChooseTopics(topics, {}, "a.bag");
  EXPECT_EQ(choice.lidar, 4U);
  EXPECT_EQ(choice.image, 1U);
  EXPECT_EQ(choice.camera_info, 0U);
  const TopicChoice named = ChooseTopics(topics, {"", "/debug/image"}, "a.bag");
  EXPECT_EQ(named.image, 2U);
  EXPECT_EQ(named.camera_info, std::nullopt);
  EXPECT_EQ(ChooseTopics(topics, {"", "/cam/image"}, "a.bag").image, 1U);
}

TEST(TopicChoice, SeveralAreListedWithTheOption) {
  const std::vector<MessageTopic> topics = {
      Topic("/front/points", "PointCloud2"),     Topic("/left/camera_info", "CameraInfo"),
      Topic("/left/image", "Image", 7),          Topic("/rear/points", "PointCloud2"),
      Topic("/right/camera_info", "CameraInfo"), Topic("/right/image", "Image")};
  const std::string lidars = TextOfError(topics, {});
  EXPECT_THAT(lidars, HasSubstr("--lidar-topic"));
  EXPECT_THAT(lidars, HasSubstr("/rear/points (sensor_msgs/msg/PointCloud2, 5 messages)"));
  const std::string images = TextOfError(topics, {"/rear/points", ""});
  EXPECT_THAT(images, HasSubstr("--image-topic"));
  EXPECT_THAT(images, HasSubstr("/left/image (sensor_msgs/msg/Image, 7 messages)"));
}

TEST(TopicChoice, PacketsAreNoScans) {
  const std::vector<MessageTopic> topics = {
      {"/packets", "velodyne_msgs/VelodyneScan", MessageEncoding::kRos1, 9}};
  EXPECT_THAT(TextOfError(topics, {}), HasSubstr("only raw packets"));
  EXPECT_THAT(TextOfError({}, {}), HasSubstr("topics: none"));
}

TEST(TopicChoice, RectifiedByName) {
  EXPECT_TRUE(IsRectifiedTopic("/cam/image_rect_color/compressed"));
  EXPECT_FALSE(IsRectifiedTopic("/rect/image_raw"));
}

}  // namespace
}  // namespace tvl
