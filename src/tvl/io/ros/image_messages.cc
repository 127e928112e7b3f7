#include "tvl/io/ros/image_messages.h"

#include <algorithm>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// No camera of a robot has more; it bounds what a few bytes of a compressed image may ask for.
constexpr uint64_t kMostPixels = uint64_t{1} << 26;
// Nor does a compressed image hold more in a byte: the best that PNG's deflate can do is 1032 to 1,
// and JPEG, with two bits or more a block, does less.
constexpr uint64_t kMostPixelsAByte = 1100;
constexpr int kAsItIs = -1;

struct RawEncoding {
  int type;        // of OpenCV
  int conversion;  // of cv::cvtColor, or kAsItIs
};

// sensor_msgs/image_encodings.h. OpenCV names Bayer patterns by the second row's second and third
// pixel, ROS by the first four.
const std::map<std::string, RawEncoding>& RawEncodings() {
  static const std::map<std::string, RawEncoding> kEncodings = {
      {"mono8", {CV_8UC1, kAsItIs}},
      {"8UC1", {CV_8UC1, kAsItIs}},
      {"mono16", {CV_16UC1, kAsItIs}},
      {"16UC1", {CV_16UC1, kAsItIs}},
      {"bgr8", {CV_8UC3, kAsItIs}},
      {"8UC3", {CV_8UC3, kAsItIs}},
      {"bgr16", {CV_16UC3, kAsItIs}},
      {"16UC3", {CV_16UC3, kAsItIs}},
      {"rgb8", {CV_8UC3, cv::COLOR_RGB2BGR}},
      {"rgb16", {CV_16UC3, cv::COLOR_RGB2BGR}},
      {"bgra8", {CV_8UC4, cv::COLOR_BGRA2BGR}},
      {"8UC4", {CV_8UC4, cv::COLOR_BGRA2BGR}},
      {"rgba8", {CV_8UC4, cv::COLOR_RGBA2BGR}},
      {"bayer_rggb8", {CV_8UC1, cv::COLOR_BayerBG2BGR}},
      {"bayer_bggr8", {CV_8UC1, cv::COLOR_BayerRG2BGR}},
      {"bayer_gbrg8", {CV_8UC1, cv::COLOR_BayerGR2BGR}},
      {"bayer_grbg8", {CV_8UC1, cv::COLOR_BayerGB2BGR}},
      {"bayer_rggb16", {CV_16UC1, cv::COLOR_BayerBG2BGR}},
      {"bayer_bggr16", {CV_16UC1, cv::COLOR_BayerRG2BGR}},
      {"bayer_gbrg16", {CV_16UC1, cv::COLOR_BayerGR2BGR}},
      {"bayer_grbg16", {CV_16UC1, cv::COLOR_BayerGB2BGR}},
      {"yuv422", {CV_8UC2, cv::COLOR_YUV2BGR_UYVY}},
      {"uyvy", {CV_8UC2, cv::COLOR_YUV2BGR_UYVY}},
      {"yuv422_yuy2", {CV_8UC2, cv::COLOR_YUV2BGR_YUY2}},
      {"yuyv", {CV_8UC2, cv::COLOR_YUV2BGR_YUY2}}};
  return kEncodings;
}

bool HostIsBigEndian() { return __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__; }

void SwapBytes16(cv::Mat* image) {
  for (int v = 0; v < image->rows; ++v) {
    auto* row = image->ptr<uint8_t>(v);
    const size_t bytes = static_cast<size_t>(image->cols) * image->elemSize();
    for (size_t k = 0; k + 1 < bytes; k += 2) std::swap(row[k], row[k + 1]);
  }
}

struct RawPixels {
  uint32_t height = 0, width = 0, step = 0;
  bool big_endian = false;
  const uint8_t* data = nullptr;
  size_t bytes = 0;
};

cv::Mat ConvertRaw(const RawPixels& raw, const RawEncoding& encoding, const std::string& place) {
  const size_t row_bytes = size_t{raw.width} * CV_ELEM_SIZE(encoding.type);
  TVL_CHECK_INPUT(raw.width > 0 && raw.height > 0 &&
                  uint64_t{raw.width} * raw.height <= kMostPixels)
      << place << ": an image of " << raw.width << " x " << raw.height << " pixels";
  TVL_CHECK_INPUT(raw.step >= row_bytes && raw.bytes >= row_bytes &&
                  raw.height - 1 <= (raw.bytes - row_bytes) / raw.step)
      << place << ": " << raw.height << " rows of " << raw.step << " bytes (" << raw.width
      << " pixels) do not fit into " << raw.bytes << " bytes";
  // OpenCV has no constant matrices over foreign memory; it is only read, and copied below.
  const cv::Mat stored(static_cast<int>(raw.height), static_cast<int>(raw.width), encoding.type,
                       const_cast<uint8_t*>(raw.data), raw.step);
  cv::Mat image = stored.clone();
  if (image.depth() == CV_16U && raw.big_endian != HostIsBigEndian()) SwapBytes16(&image);
  if (encoding.conversion == kAsItIs) return image;
  cv::Mat converted;
  cv::cvtColor(image, converted, encoding.conversion);
  return converted;
}

ImageMessage DecodeRaw(const StoredMessage& message) {
  WireReader reader = message.Reader();
  ImageMessage decoded;
  decoded.header = ReadHeader(&reader);
  RawPixels raw;
  raw.height = reader.Number<uint32_t>();
  raw.width = reader.Number<uint32_t>();
  decoded.encoding = reader.String();
  raw.big_endian = reader.Number<uint8_t>() != 0;
  raw.step = reader.Number<uint32_t>();
  raw.bytes = reader.Count(1);
  raw.data = reader.Bytes(raw.bytes);
  const auto found = RawEncodings().find(decoded.encoding);
  TVL_CHECK_INPUT(found != RawEncodings().end())
      << message.place << ": image encoding '" << decoded.encoding.substr(0, 64)
      << "' is not known";
  try {
    decoded.image = ConvertRaw(raw, found->second, message.place);
  } catch (const cv::Exception& error) {
    throw InputError(message.place + ": " + error.err);
  }
  return decoded;
}

uint32_t BigEndian(const uint8_t* bytes, size_t count) {
  uint32_t value = 0;
  for (size_t k = 0; k < count; ++k) value = value << 8U | bytes[k];
  return value;
}

// Width times height as the image's own header says; empty for what is neither PNG (w3.org/TR/png,
// IHDR) nor JPEG (ITU-T T.81, frame header SOF).
std::optional<uint64_t> PixelsOf(const uint8_t* data, size_t bytes) {
  constexpr std::array<uint8_t, 8> kPng = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  if (bytes >= 24 && std::equal(kPng.begin(), kPng.end(), data)) {
    return uint64_t{BigEndian(data + 16, 4)} * BigEndian(data + 20, 4);
  }
  if (bytes < 4 || data[0] != 0xFF || data[1] != 0xD8) return std::nullopt;
  for (size_t k = 2; k + 9 <= bytes;) {
    if (data[k] != 0xFF) return std::nullopt;
    const uint8_t marker = data[k + 1];
    if (marker == 0xFF || (marker >= 0xD0 && marker <= 0xD8) || marker == 0x01) {
      k += marker == 0xFF ? 1 : 2;  // fill bytes, and markers that stand alone
      continue;
    }
    const bool frame =
        marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (frame) return uint64_t{BigEndian(data + k + 5, 2)} * BigEndian(data + k + 7, 2);
    k += 2 + BigEndian(data + k + 2, 2);
  }
  return std::nullopt;
}

ImageMessage DecodeCompressed(const StoredMessage& message) {
  WireReader reader = message.Reader();
  ImageMessage decoded;
  decoded.header = ReadHeader(&reader);
  decoded.encoding = reader.String();
  const size_t bytes = reader.Count(1);
  const uint8_t* data = reader.Bytes(bytes);
  const std::optional<uint64_t> pixels = PixelsOf(data, bytes);
  TVL_CHECK_INPUT(pixels.has_value())
      << message.place << ": neither a JPEG nor a PNG image (format '"
      << decoded.encoding.substr(0, 64) << "')";
  TVL_CHECK_INPUT(*pixels > 0 && *pixels <= std::min(kMostPixels, bytes * kMostPixelsAByte))
      << message.place << ": an image of " << *pixels << " pixels in " << bytes << " bytes";
  try {
    const cv::Mat stored(1, static_cast<int>(bytes), CV_8UC1, const_cast<uint8_t*>(data));
    decoded.image = cv::imdecode(stored, cv::IMREAD_UNCHANGED);
    if (decoded.image.channels() == 4) {
      cv::cvtColor(decoded.image, decoded.image, cv::COLOR_BGRA2BGR);
    }
  } catch (const cv::Exception& error) {
    throw InputError(message.place + ": " + error.err);
  }
  const int depth = decoded.image.depth(), channels = decoded.image.channels();
  TVL_CHECK_INPUT(!decoded.image.empty() && (depth == CV_8U || depth == CV_16U) &&
                  (channels == 1 || channels == 3))
      << message.place << ": not a readable 8 or 16 bit image";
  return decoded;
}

}  // namespace

ImageMessage DecodeImageMessage(MessageKind kind, const StoredMessage& message) {
  TVL_CHECK(kind == MessageKind::kImage || kind == MessageKind::kCompressedImage);
  return kind == MessageKind::kImage ? DecodeRaw(message) : DecodeCompressed(message);
}

}  // namespace tvl
