#include "tvl/io/ros/messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "tvl/base/check.h"
#include "tvl/io/ros/image_messages.h"
#include "tvl/io/ros/point_messages.h"
#include "tvl/io/ros/test_bags.h"

namespace tvl {
namespace {

using testing::HasSubstr;

StoredMessage Message(const BytesBuilder& builder,
                      MessageEncoding encoding = MessageEncoding::kRos1) {
  auto owner = std::make_shared<const std::vector<uint8_t>>(builder.bytes());
  return {{owner, owner->data(), owner->size()}, encoding, "a.bag: /topic: message 0"};
}

template <typename Function>
std::string TextOfError(const Function& function) {
  try {
    function();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

BytesBuilder Cloud(uint32_t height, uint32_t width, uint32_t z_offset, uint32_t step,
                   uint32_t row_step, const std::vector<uint8_t>& data) {
  BytesBuilder builder;
  builder.Header(1, 2, "lidar").Add(height).Add(width).Add<uint32_t>(3);
  uint32_t offset = 0;
  for (const char* name : {"x", "y", "z"}) {
    builder.Text(name).Add(offset == 8 ? z_offset : offset).Add<uint8_t>(7).Add<uint32_t>(1);
    offset += 4;
  }
  builder.Add<uint8_t>(0).Add(step).Add(row_step).Add(static_cast<uint32_t>(data.size()));
  return builder.Raw(data).Add<uint8_t>(1);
}

RawScan Decode(const BytesBuilder& builder) {
  return DecodePointsMessage(MessageKind::kPointCloud2, Message(builder)).scan;
}

TEST(Messages, TypesOfRos1AndRos2) {
  EXPECT_EQ(KindOfType("sensor_msgs/PointCloud2"), MessageKind::kPointCloud2);
  EXPECT_EQ(KindOfType("sensor_msgs/msg/PointCloud2"), MessageKind::kPointCloud2);
  EXPECT_EQ(KindOfType("livox_ros_driver/CustomMsg"), MessageKind::kLivoxPoints);
  EXPECT_EQ(KindOfType("tf2_msgs/msg/TFMessage"), MessageKind::kTransforms);
  EXPECT_EQ(KindOfType("other_msgs/Image"), MessageKind::kOther);
  EXPECT_EQ(KindOfType("Image"), MessageKind::kOther);
}

TEST(PointMessages, RowsMayBePaddedAndRowStepsWrong) {
  std::vector<uint8_t> data(2 * 28, 0);
  data[28 + 3] = 0x40;  // x of the second row's first point: 2
  EXPECT_EQ(Decode(Cloud(2, 2, 8, 12, 28, data)).points[2].x(), 2.0F);
  std::vector<uint8_t> tight(48, 0);
  tight[24 + 3] = 0x40;
  EXPECT_EQ(Decode(Cloud(2, 2, 8, 12, 0, tight)).points[2].x(), 2.0F);
}

TEST(PointMessages, NumbersThatContradictTheDataAreErrors) {
  const std::vector<uint8_t> data(24, 0);
  EXPECT_EQ(Decode(Cloud(1, 2, 8, 12, 24, data)).size(), 2U);
  EXPECT_THAT(TextOfError([&] { Decode(Cloud(1, 4'000'000'000U, 8, 12, 24, data)); }),
              HasSubstr("a.bag: /topic: message 0"));
  EXPECT_THAT(TextOfError([&] { Decode(Cloud(1, 1'000'000, 8, 12, 24, data)); }),
              HasSubstr("do not fit"));
  EXPECT_THAT(TextOfError([&] { Decode(Cloud(1, 2, 9, 12, 24, data)); }), HasSubstr("field 'z'"));
  EXPECT_THAT(TextOfError([&] { Decode(Cloud(1, 2, 8, 0, 24, data)); }), HasSubstr("beyond the 0"));
  EXPECT_EQ(Decode(Cloud(1, 0, 8, 12, 0, {})).size(), 0U);
  EXPECT_EQ(Decode(Cloud(4'000'000'000U, 0, 8, 12, 0, {})).size(), 0U);  // at once
}

BytesBuilder RawImage(const std::string& encoding, uint32_t height, uint32_t width, uint32_t step,
                      const std::vector<uint8_t>& data, bool big_endian = false) {
  BytesBuilder builder;
  builder.Header(1, 2, "camera").Add(height).Add(width).Text(encoding);
  builder.Add<uint8_t>(big_endian ? 1 : 0).Add(step).Add(static_cast<uint32_t>(data.size()));
  return builder.Raw(data);
}

cv::Mat DecodeImage(const BytesBuilder& builder) {
  return DecodeImageMessage(MessageKind::kImage, Message(builder)).image;
}

TEST(ImageMessages, RawEncodings) {
  EXPECT_EQ(DecodeImage(RawImage("mono8", 1, 2, 3, {5, 6, 0})).at<uint8_t>(0, 1), 6);
  EXPECT_EQ(DecodeImage(RawImage("rgb8", 1, 1, 3, {1, 2, 3})).at<cv::Vec3b>(0, 0),
            cv::Vec3b(3, 2, 1));
  EXPECT_EQ(DecodeImage(RawImage("bgra8", 1, 1, 4, {1, 2, 3, 4})).at<cv::Vec3b>(0, 0),
            cv::Vec3b(1, 2, 3));
  EXPECT_EQ(DecodeImage(RawImage("rgba8", 1, 1, 4, {1, 2, 3, 4})).at<cv::Vec3b>(0, 0),
            cv::Vec3b(3, 2, 1));
  EXPECT_EQ(DecodeImage(RawImage("mono16", 1, 1, 2, {1, 2})).at<uint16_t>(0, 0), 0x0201);
  EXPECT_EQ(DecodeImage(RawImage("16UC1", 1, 1, 2, {1, 2}, true)).at<uint16_t>(0, 0), 0x0102);
}

// A field of one colour behind each pattern: red 200, green 100, blue 50.
TEST(ImageMessages, BayerPatternsBecomeTheirColour) {
  for (const std::string pattern : {"rggb", "bggr", "gbrg", "grbg"}) {
    std::vector<uint8_t> data;
    for (size_t v = 0; v < 8; ++v) {
      for (size_t u = 0; u < 8; ++u) {
        const char colour = pattern[2 * (v % 2) + u % 2];
        data.push_back(colour == 'r' ? 200 : colour == 'g' ? 100 : 50);
      }
    }
    const cv::Mat image = DecodeImage(RawImage("bayer_" + pattern + "8", 8, 8, 8, data));
    EXPECT_EQ(image.at<cv::Vec3b>(4, 4), cv::Vec3b(50, 100, 200)) << pattern;
  }
}

TEST(ImageMessages, NumbersThatContradictTheDataAreErrors) {
  EXPECT_THAT(TextOfError([] {
                DecodeImage(RawImage("mono8", 3, 2, 2, {1, 2, 3, 4}));
              }),
              HasSubstr("do not fit"));
  EXPECT_THAT(TextOfError([] {
                DecodeImage(RawImage("mono8", 2, 4, 2, {1, 2, 3, 4}));
              }),
              HasSubstr("do not fit"));
  EXPECT_THAT(TextOfError([] { DecodeImage(RawImage("mono8", UINT32_MAX, UINT32_MAX, 2, {1})); }),
              HasSubstr("4294967295 x"));
  EXPECT_THAT(TextOfError([] {
                DecodeImage(RawImage("32FC1", 1, 1, 4, {1, 2, 3, 4}));
              }),
              HasSubstr("encoding '32FC1'"));
}

BytesBuilder Compressed(const std::vector<uint8_t>& data) {
  BytesBuilder builder;
  builder.Header(1, 2, "camera").Text("png").Add(static_cast<uint32_t>(data.size()));
  return builder.Raw(data);
}

TEST(ImageMessages, CompressedImagesAreCheckedBeforeTheyAreDecoded) {
  const auto decode = [](const std::vector<uint8_t>& data) {
    return DecodeImageMessage(MessageKind::kCompressedImage, Message(Compressed(data))).image;
  };
  const cv::Mat grey(20, 30, CV_8UC1, cv::Scalar(77));
  for (const char* kind : {".png", ".jpg"}) {
    std::vector<uint8_t> data;
    cv::imencode(kind, grey, data);
    EXPECT_EQ(decode(data).size(), cv::Size(30, 20)) << kind;
    EXPECT_NEAR(decode(data).at<uint8_t>(10, 10), 77, 1);
    data.resize(20);
    EXPECT_THROW(decode(data), InputError) << kind;
  }
  std::vector<uint8_t> huge;
  cv::imencode(".png", grey, huge);
  huge[17] = 0x20;  // its width: 2 million
  EXPECT_THAT(TextOfError([&] { decode(huge); }), HasSubstr("pixels"));
  EXPECT_THAT(TextOfError([&] { decode({'B', 'M', 0, 0}); }), HasSubstr("neither a JPEG"));
}

BytesBuilder Info(const std::string& model, const std::vector<double>& D, uint32_t binning = 0,
                  uint32_t roi_x = 0, uint32_t roi_width = 0) {
  BytesBuilder builder = BytesBuilder::Cdr();
  builder.Header(1, 2, "/camera").Add<uint32_t>(480).Add<uint32_t>(640).Text(model);
  builder.Add(static_cast<uint32_t>(D.size()));
  for (const double d : D) builder.Add(d);
  for (const double k : {500., 0., 320., 0., 510., 240., 0., 0., 1.}) builder.Add(k);
  for (const double r : {1., 0., 0., 0., 1., 0., 0., 0., 1.}) builder.Add(r);
  for (const double p : {400., 0., 300., 0., 0., 400., 200., 0., 0., 0., 1., 0.}) builder.Add(p);
  builder.Add(binning).Add(binning).Add(roi_x).Add<uint32_t>(0);
  return builder.Add<uint32_t>(roi_width > 0 ? 480 : 0).Add(roi_width).Add<uint8_t>(0);
}

Camera CameraFrom(const BytesBuilder& builder, bool rectified = false) {
  const CameraInfoMessage info = DecodeCameraInfo(Message(builder, MessageEncoding::kCdr));
  EXPECT_EQ(info.header.frame_id, "camera");
  return CameraOf(info, rectified, "/camera_info");
}

TEST(CameraInfo, ModelsAndTheirCoefficients) {
  const Camera plumb = CameraFrom(Info("plumb_bob", {1, 2, 3, 4, 5}));
  EXPECT_EQ(plumb.distortion, (std::array<double, 8>{1, 2, 3, 4, 5}));
  EXPECT_EQ(plumb.fy_px, 510.0);
  EXPECT_EQ(plumb.width_px, 640);
  const Camera rational = CameraFrom(Info("rational_polynomial", {1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(rational.distortion_model, DistortionModel::kRational);
  EXPECT_EQ(rational.distortion[7], 8.0);
  const Camera fisheye = CameraFrom(Info("equidistant", {1, 2, 3, 4}));
  EXPECT_EQ(fisheye.distortion_model, DistortionModel::kEquidistant);
  EXPECT_FALSE(CameraFrom(Info("", {})).IsDistorted());
  EXPECT_THAT(TextOfError([] { CameraFrom(Info("fancy", {1})); }), HasSubstr("'fancy'"));
  EXPECT_THAT(TextOfError([] {
                CameraFrom(Info("equidistant", {1, 2, 3, 4, 5}));
              }),
              HasSubstr("5 coefficients"));
}

TEST(CameraInfo, RectifiedBinnedAndCropped) {
  const Camera rectified = CameraFrom(Info("plumb_bob", {1, 2, 3, 4, 5}), true);
  EXPECT_EQ(rectified.fx_px, 400.0);
  EXPECT_FALSE(rectified.IsDistorted());
  const Camera cropped = CameraFrom(Info("", {}, 2, 100, 300));
  EXPECT_EQ(cropped.fx_px, 250.0);
  EXPECT_EQ(cropped.cx_px, 110.0);
  EXPECT_EQ(cropped.width_px, 150);
}

BytesBuilder TransformMessage(uint32_t count, double qw) {
  BytesBuilder builder;
  builder.Add(count).Header(1, 2, "/base").Text("lidar");
  for (const double v : {1., 2., 3., 0., 0., 0., qw}) builder.Add(v);
  return builder;
}

TEST(Transforms, RigidOnesOnly) {
  const std::vector<FrameTransform> read = DecodeTransforms(Message(TransformMessage(1, 1.0)));
  ASSERT_EQ(read.size(), 1U);
  EXPECT_EQ(read[0].parent, "base");
  EXPECT_EQ(read[0].T_parent_child.t(), Eigen::Vector3d(1, 2, 3));
  EXPECT_THAT(TextOfError([] { DecodeTransforms(Message(TransformMessage(1, 0.5))); }),
              HasSubstr("no rigid motion"));
  EXPECT_THAT(TextOfError([] { DecodeTransforms(Message(TransformMessage(1'000'000, 1.0))); }),
              HasSubstr("does not fit"));
}

}  // namespace
}  // namespace tvl
