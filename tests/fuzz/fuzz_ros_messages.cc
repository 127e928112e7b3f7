// Any bytes as a message: the first byte chooses kind and encoding. Decoding throws InputError or
// succeeds; of JPEG and PNG it is OpenCV's libraries that decode.
#include <array>

#include "tvl/base/check.h"
#include "tvl/io/ros/image_messages.h"
#include "tvl/io/ros/point_messages.h"

namespace tvl {
namespace {

void Decode(MessageKind kind, const StoredMessage& message) {
  switch (kind) {
    case MessageKind::kImage:
    case MessageKind::kCompressedImage:
      DecodeImageMessage(kind, message);
      return;
    case MessageKind::kCameraInfo:
      CameraOf(DecodeCameraInfo(message), false, message.place);
      return;
    case MessageKind::kTransforms:
      DecodeTransforms(message);
      return;
    default:
      DecodePointsMessage(kind, message);
  }
}

}  // namespace
}  // namespace tvl

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t bytes) {
  using tvl::MessageKind;
  constexpr std::array<MessageKind, 6> kKinds = {
      MessageKind::kPointCloud2,     MessageKind::kLivoxPoints, MessageKind::kImage,
      MessageKind::kCompressedImage, MessageKind::kCameraInfo,  MessageKind::kTransforms};
  if (bytes == 0) return 0;
  const MessageKind kind = kKinds[(data[0] >> 1U) % kKinds.size()];
  const auto encoding =
      (data[0] & 1U) != 0 ? tvl::MessageEncoding::kCdr : tvl::MessageEncoding::kRos1;
  // A copy of its own, so that a read beyond its end is seen.
  auto owner = std::make_shared<const std::vector<uint8_t>>(data + 1, data + bytes);
  try {
    tvl::Decode(kind, {{owner, owner->data(), owner->size()}, encoding, "fuzz"});
  } catch (const tvl::InputError&) {
    return 0;
  }
  return 0;
}
