#include "tvl/io/ros/bag_recording.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/io/ros/image_messages.h"
#include "tvl/io/ros/message_stream.h"
#include "tvl/io/ros/point_messages.h"
#include "tvl/io/ros/tf_tree.h"

namespace tvl {
namespace {

// Messages that are tried until one tells fields, frame or calibration.
constexpr size_t kMostTried = 10;
// Of /tf, which repeats itself at 10 to 100 Hz: seconds to minutes, in which what moves has moved.
constexpr size_t kMostMovingMessages = 1000;

class BagScans : public ScanStream {
 public:
  explicit BagScans(std::shared_ptr<const MessageStream> messages)
      : messages_(std::move(messages)), kind_(KindOfType(messages_->topic().type)) {}
  size_t size() const override { return messages_->size(); }
  std::optional<Timestamp> Stamp(size_t index) const override { return messages_->Stamp(index); }
  RawScanRead Read(size_t index) const override {
    StoredMessage message;
    try {
      message = messages_->Read(index);
    } catch (const InputError& error) {
      return {nullptr, {{FrameFault::Kind::kMissingScan, error.what()}}};
    }
    try {
      auto scan = std::make_shared<RawScan>(DecodePointsMessage(kind_, message).scan);
      if (scan->size() > 0) return {std::move(scan), {}};
      return {nullptr, {{FrameFault::Kind::kEmptyScan, message.place + ": no points"}}};
    } catch (const InputError& error) {
      return {nullptr, {{FrameFault::Kind::kTruncatedScan, error.what()}}};
    }
  }

 private:
  std::shared_ptr<const MessageStream> messages_;
  MessageKind kind_;
};

class BagImages : public ImageStream {
 public:
  // Images of another size than this are faults; 0 by 0: of any size.
  BagImages(std::shared_ptr<const MessageStream> messages, int width_px, int height_px)
      : messages_(std::move(messages)),
        kind_(KindOfType(messages_->topic().type)),
        width_px_(width_px),
        height_px_(height_px) {}
  size_t size() const override { return messages_->size(); }
  std::optional<Timestamp> Stamp(size_t index) const override { return messages_->Stamp(index); }
  ImageRead Read(size_t index) const override {
    StoredMessage message;
    try {
      message = messages_->Read(index);
    } catch (const InputError& error) {
      return {{}, {{FrameFault::Kind::kMissingImage, error.what()}}};
    }
    try {
      const cv::Mat image = DecodeImageMessage(kind_, message).image;
      return CheckImage(image, message.place, width_px_, height_px_);
    } catch (const InputError& error) {
      return {{}, {{FrameFault::Kind::kUnreadableImage, error.what()}}};
    }
  }

 private:
  std::shared_ptr<const MessageStream> messages_;
  MessageKind kind_;
  int width_px_, height_px_;
};

// The first of the messages that `decode` takes; empty if it takes none of the first few, then the
// reason becomes a warning.
template <typename Decode>
auto FirstReadable(const MessageStream& messages, const Decode& decode,
                   std::vector<std::string>* warnings)
    -> std::optional<decltype(decode(messages.Read(0)))> {
  std::string first_error = messages.Place(0) + ": there is none";
  for (size_t k = 0; k < std::min(kMostTried, messages.size()); ++k) {
    try {
      return decode(messages.Read(k));
    } catch (const InputError& error) {
      if (k == 0) first_error = error.what();
    }
  }
  warnings->push_back(first_error);
  return std::nullopt;
}

// Everything about a bag while it is opened.
struct Opened {
  std::string path;
  std::shared_ptr<const MessageStore> store;
  TopicChoice choice;
  std::shared_ptr<MessageStream> scans, images;  // images: null if none
  std::vector<std::vector<MessageLocation>> camera_info, static_transforms, moving_transforms;
};

std::vector<std::vector<MessageLocation>> Take(MessageIndex* index, size_t begin, size_t count) {
  const auto first = index->topics.begin() + static_cast<std::ptrdiff_t>(begin);
  return {std::make_move_iterator(first),
          std::make_move_iterator(first + static_cast<std::ptrdiff_t>(count))};
}

// One walk through the index for all topics.
void ReadIndex(Opened* bag, Recording* recording) {
  const TopicChoice& choice = bag->choice;
  std::vector<size_t> wanted = {choice.lidar};
  if (choice.image) wanted.push_back(*choice.image);
  if (choice.camera_info) wanted.push_back(*choice.camera_info);
  for (const auto* more : {&choice.static_transforms, &choice.moving_transforms}) {
    wanted.insert(wanted.end(), more->begin(), more->end());
  }
  MessageIndex index = bag->store->Index(wanted);
  std::vector<std::string>& warnings = recording->warnings;
  warnings.insert(warnings.end(), index.warnings.begin(), index.warnings.end());
  size_t next = choice.image ? 2 : 1;
  std::vector<MessageTopic> topics;
  for (size_t k = 0; k < next; ++k) topics.push_back(bag->store->topics()[wanted[k]]);
  const auto streams = OpenStreams(bag->store, topics, Take(&index, 0, next), bag->path);
  for (const auto& stream : streams) {
    warnings.insert(warnings.end(), stream->warnings().begin(), stream->warnings().end());
  }
  bag->scans = streams.front();
  if (choice.image) bag->images = streams.back();
  const size_t infos = choice.camera_info ? 1 : 0;
  bag->camera_info = Take(&index, next, infos);
  next += infos;
  bag->static_transforms = Take(&index, next, choice.static_transforms.size());
  next += choice.static_transforms.size();
  bag->moving_transforms = Take(&index, next, choice.moving_transforms.size());
}

bool Overlap(const MessageStream::Span& a, const MessageStream::Span& b) {
  return a.first <= b.last && b.first <= a.last;
}

// Some lidars count from when they were switched on: their stamps say nothing to the camera's.
void CompareClocks(const Opened& bag, Recording* recording) {
  if (!bag.images || bag.images->size() == 0 || bag.scans->size() == 0) return;
  if (Overlap(bag.scans->StampSpan(), bag.images->StampSpan())) return;
  if (!Overlap(bag.scans->LogSpan(), bag.images->LogSpan())) return;
  const double apart_s =
      SecondsBetween(bag.images->StampSpan().first, bag.scans->StampSpan().first);
  recording->warnings.push_back(bag.path +
                                ": the stamps of scans and images come from different clocks (" +
                                std::to_string(apart_s) +
                                " s apart): the times of recording are taken, which are late by "
                                "the time of transport");
  bag.scans->UseLogTimes();
  bag.images->UseLogTimes();
}

// Calls visit(transform) for the messages of topics until `most` messages are read.
template <typename Visit>
void VisitTransforms(const Opened& bag, const std::vector<size_t>& topics,
                     const std::vector<std::vector<MessageLocation>>& messages, size_t most,
                     Recording* recording, const Visit& visit) {
  for (size_t t = 0; t < topics.size(); ++t) {
    const MessageTopic& topic = bag.store->topics()[topics[t]];
    for (size_t k = 0; k < std::min(most, messages[t].size()); ++k) {
      const std::string place = bag.path + ": " + topic.name + ": message " + std::to_string(k);
      try {
        const StoredMessage message{bag.store->Read(messages[t][k]), topic.encoding, place};
        for (const FrameTransform& transform : DecodeTransforms(message)) visit(transform);
      } catch (const InputError& error) {
        recording->warnings.push_back(error.what());
      }
    }
  }
}

TfTree ReadTransforms(const Opened& bag, Recording* recording) {
  TfTree tree;
  VisitTransforms(bag, bag.choice.static_transforms, bag.static_transforms, kMostMovingMessages,
                  recording, [&](const FrameTransform& t) { tree.AddStatic(t); });
  VisitTransforms(bag, bag.choice.moving_transforms, bag.moving_transforms, kMostMovingMessages,
                  recording, [&](const FrameTransform& t) { tree.AddMoving(t); });
  return tree;
}

void FindExtrinsics(const Opened& bag, const std::string& camera_frame,
                    const std::string& lidar_frame, Recording* recording) {
  const TfTree tree = ReadTransforms(bag, recording);
  try {
    TVL_CHECK_INPUT(!tree.empty()) << "no transforms (/tf_static) in the bag";
    recording->T_cam_lidar = tree.Transform(camera_frame, lidar_frame);
    recording->notes.push_back("extrinsics: from frame '" + lidar_frame + "' to '" + camera_frame +
                               "' by the transforms of the bag");
    if (!tree.RestsOnMoving(camera_frame, lidar_frame)) return;
    recording->warnings.push_back(bag.path +
                                  ": the transform between camera and lidar comes from /tf, where "
                                  "it did not change; /tf_static does not have it");
  } catch (const InputError& error) {
    recording->warnings.push_back(bag.path + ": extrinsics of the camera not known: " +
                                  error.what() + "; give them with a calibration");
  }
}

// The rotation from the camera's frame to that of its rectified images.
Rigid3d Rectification(const CameraInfoMessage& info) {
  const Eigen::Matrix3d R =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(info.R.data());
  // All zero where the driver does not set it.
  const bool is_rotation = (R * R.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-3;
  return is_rotation ? Rigid3d(R, Eigen::Vector3d::Zero()) : Rigid3d();
}

std::optional<CameraInfoMessage> ReadCameraInfo(const Opened& bag, Recording* recording) {
  const std::string& image_topic = bag.images->topic().name;
  if (!bag.choice.camera_info) {
    recording->warnings.push_back(bag.path + ": " + image_topic +
                                  ": no CameraInfo beside it: camera not known; give it with a "
                                  "calibration");
    return std::nullopt;
  }
  const MessageTopic& topic = bag.store->topics()[*bag.choice.camera_info];
  std::vector<MessageLocation> first = bag.camera_info.front();
  first.resize(std::min(first.size(), kMostTried));
  const MessageStream messages(bag.store, topic, first, bag.path);
  return FirstReadable(messages, DecodeCameraInfo, &recording->warnings);
}

void FindCamera(const Opened& bag, const std::optional<CameraInfoMessage>& info, cv::Size image,
                Recording* recording) {
  if (!info) return;
  const std::string source = bag.path + ": " + bag.store->topics()[*bag.choice.camera_info].name;
  try {
    const bool rectified = IsRectifiedTopic(bag.images->topic().name);
    Camera camera = CameraOf(*info, rectified, source);
    if (camera.width_px == 0 || camera.height_px == 0) {
      camera.width_px = image.width, camera.height_px = image.height;
    }
    TVL_CHECK_INPUT(image.area() == 0 ||
                    (camera.width_px == image.width && camera.height_px == image.height))
        << source << ": is of images of " << camera.width_px << "x" << camera.height_px
        << ", the images are " << image.width << "x" << image.height;
    recording->camera = camera;
    recording->notes.push_back(
        "camera: " + bag.store->topics()[*bag.choice.camera_info].name + ", " +
        (rectified ? "rectified" : "model '" + info->distortion_model + "'"));
  } catch (const InputError& error) {
    recording->warnings.push_back(std::string(error.what()) +
                                  ": camera not known; give it with a calibration");
  }
}

void DescribeScans(const Opened& bag, const PointsMessage& first, Recording* recording) {
  recording->notes.push_back("scans: " + DescribeTopic(bag.scans->topic()) + ", frame '" +
                             first.header.frame_id + "', " + std::to_string(first.scan.height) +
                             " x " + std::to_string(first.scan.width) +
                             " points: " + DescribeFields(first.fields));
}

// Images with their camera and its place.
void OpenImages(const Opened& bag, const std::string& lidar_frame, Recording* recording) {
  const MessageKind kind = KindOfType(bag.images->topic().type);
  const auto decode = [kind](const StoredMessage& m) { return DecodeImageMessage(kind, m); };
  const std::optional<ImageMessage> first =
      FirstReadable(*bag.images, decode, &recording->warnings);
  const cv::Size size = first ? first->image.size() : cv::Size();
  if (first) {
    recording->notes.push_back("images: " + DescribeTopic(bag.images->topic()) + ", frame '" +
                               first->header.frame_id + "', " + std::to_string(size.width) + "x" +
                               std::to_string(size.height) + " " + first->encoding);
  }
  const std::optional<CameraInfoMessage> info = ReadCameraInfo(bag, recording);
  FindCamera(bag, info, size, recording);
  recording->images = std::make_unique<BagImages>(bag.images, size.width, size.height);
  std::string frame = first ? first->header.frame_id : "";
  if (frame.empty() && info) frame = info->header.frame_id;
  FindExtrinsics(bag, frame, lidar_frame, recording);
  if (recording->T_cam_lidar && info && IsRectifiedTopic(bag.images->topic().name)) {
    recording->T_cam_lidar = Rectification(*info) * *recording->T_cam_lidar;
  }
}

}  // namespace

Recording OpenBag(const std::string& path, const BagOptions& options) {
  Opened bag;
  bag.path = path;
  bag.store = OpenBagFile(path);
  Recording recording;
  recording.name = std::filesystem::path(path).filename().string();
  recording.warnings = bag.store->warnings();
  recording.notes.push_back(bag.store->Describe());
  for (const MessageTopic& topic : bag.store->topics()) {
    recording.notes.push_back("topic " + DescribeTopic(topic));
  }
  bag.choice = ChooseTopics(bag.store->topics(), options, path);
  ReadIndex(&bag, &recording);
  CompareClocks(bag, &recording);
  const MessageKind kind = KindOfType(bag.scans->topic().type);
  const auto decode = [kind](const StoredMessage& m) { return DecodePointsMessage(kind, m); };
  const std::optional<PointsMessage> first = FirstReadable(*bag.scans, decode, &recording.warnings);
  if (first) DescribeScans(bag, *first, &recording);
  if (bag.images) OpenImages(bag, first ? first->header.frame_id : "", &recording);
  recording.scans = std::make_unique<BagScans>(bag.scans);
  return recording;
}

}  // namespace tvl
