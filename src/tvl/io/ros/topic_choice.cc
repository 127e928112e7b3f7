#include "tvl/io/ros/topic_choice.h"

#include <algorithm>
#include <map>

#include "tvl/base/check.h"

namespace tvl {
namespace {

constexpr std::string_view kCompressedSuffix = "/compressed";

bool EndsWith(std::string_view text, std::string_view end) {
  return text.size() >= end.size() && text.substr(text.size() - end.size()) == end;
}

// Kind of a topic that can be used, else kOther.
MessageKind KindOf(const MessageTopic& topic) {
  const bool usable = topic.encoding != MessageEncoding::kOther && topic.count != uint64_t{0};
  return usable ? KindOfType(topic.type) : MessageKind::kOther;
}

bool IsScanTopic(const MessageTopic& topic) {
  const MessageKind kind = KindOf(topic);
  return kind == MessageKind::kPointCloud2 || kind == MessageKind::kLivoxPoints;
}

bool IsImageTopic(const MessageTopic& topic) {
  const MessageKind kind = KindOf(topic);
  // Depth images come as compressed images too, in a format of their own.
  return kind == MessageKind::kImage ||
         (kind == MessageKind::kCompressedImage && !EndsWith(topic.name, "/compressedDepth"));
}

// The topic that the image transport calls the raw one.
std::string BaseOf(const MessageTopic& topic) {
  const bool twin =
      KindOf(topic) == MessageKind::kCompressedImage && EndsWith(topic.name, kCompressedSuffix);
  return twin ? topic.name.substr(0, topic.name.size() - kCompressedSuffix.size()) : topic.name;
}

std::optional<size_t> FindCameraInfo(const std::vector<MessageTopic>& topics,
                                     const std::string& base) {
  for (const std::string& name_space : {base.substr(0, base.rfind('/')), base}) {
    for (size_t k = 0; k < topics.size(); ++k) {
      if (KindOf(topics[k]) == MessageKind::kCameraInfo &&
          topics[k].name == name_space + "/camera_info") {
        return k;
      }
    }
  }
  return std::nullopt;
}

std::string List(const std::vector<MessageTopic>& topics, const std::vector<size_t>& which) {
  std::string text;
  for (const size_t k : which) text += "\n  " + DescribeTopic(topics[k]);
  return text.empty() ? " none" : text;
}

std::vector<size_t> All(const std::vector<MessageTopic>& topics) {
  std::vector<size_t> all(topics.size());
  for (size_t k = 0; k < all.size(); ++k) all[k] = k;
  return all;
}

size_t ChooseLidar(const std::vector<MessageTopic>& topics, const std::string& wanted,
                   const std::string& source) {
  std::vector<size_t> found;
  bool packets = false;
  for (size_t k = 0; k < topics.size(); ++k) {
    if (IsScanTopic(topics[k])) found.push_back(k);
    packets = packets || KindOf(topics[k]) == MessageKind::kLidarPackets;
  }
  if (!wanted.empty()) {
    const auto named = std::find_if(found.begin(), found.end(),
                                    [&](size_t k) { return topics[k].name == wanted; });
    TVL_CHECK_INPUT(named != found.end())
        << source << ": --lidar-topic " << wanted
        << " is no topic with scans; these are:" << List(topics, found);
    return *named;
  }
  TVL_CHECK_INPUT(!found.empty())
      << source << ": no topic with scans (sensor_msgs/PointCloud2 or livox CustomMsg)"
      << (packets ? ", only raw packets: turn them into PointCloud2 with the lidar's driver first"
                  : "")
      << "; topics:" << List(topics, All(topics));
  TVL_CHECK_INPUT(found.size() == 1)
      << source
      << ": several topics with scans; choose one with --lidar-topic:" << List(topics, found);
  return found.front();
}

size_t NamedImage(const std::vector<MessageTopic>& topics, const std::string& wanted,
                  const std::string& source) {
  std::vector<size_t> images;
  std::optional<size_t> named;
  for (size_t k = 0; k < topics.size(); ++k) {
    if (!IsImageTopic(topics[k])) continue;
    images.push_back(k);
    // The raw topic's name stands for its twin where only that was recorded.
    if (topics[k].name == wanted || (!named && BaseOf(topics[k]) == wanted)) named = k;
  }
  TVL_CHECK_INPUT(named.has_value())
      << source << ": --image-topic " << wanted
      << " is no topic with images; these are:" << List(topics, images);
  return *named;
}

std::optional<size_t> FindImage(const std::vector<MessageTopic>& topics,
                                const std::string& source) {
  std::map<std::string, size_t> of_base;
  for (size_t k = 0; k < topics.size(); ++k) {
    if (!IsImageTopic(topics[k])) continue;
    const auto [known, is_new] = of_base.emplace(BaseOf(topics[k]), k);
    if (!is_new && KindOf(topics[k]) == MessageKind::kImage) known->second = k;
  }
  std::vector<size_t> found, with_info;
  for (const auto& [base, k] : of_base) {
    found.push_back(k);
    if (FindCameraInfo(topics, base)) with_info.push_back(k);
  }
  if (!with_info.empty()) found = with_info;
  TVL_CHECK_INPUT(found.size() <= 1)
      << source
      << ": several topics with images; choose one with --image-topic:" << List(topics, found);
  return found.empty() ? std::nullopt : std::optional<size_t>(found.front());
}

}  // namespace

std::string DescribeTopic(const MessageTopic& topic) {
  const std::string count = topic.count ? std::to_string(*topic.count) : "unknown number of";
  return topic.name + " (" + (topic.type.empty() ? "unknown type" : topic.type) + ", " + count +
         (topic.count == uint64_t{1} ? " message)" : " messages)");
}

bool IsRectifiedTopic(const std::string& image_topic) {
  const std::string_view name = image_topic;
  const std::string_view raw = EndsWith(name, kCompressedSuffix)
                                   ? name.substr(0, name.size() - kCompressedSuffix.size())
                                   : name;
  return raw.substr(raw.rfind('/') + 1).find("rect") != std::string_view::npos;
}

TopicChoice ChooseTopics(const std::vector<MessageTopic>& topics, const BagOptions& options,
                         const std::string& source) {
  TopicChoice choice;
  choice.lidar = ChooseLidar(topics, options.lidar_topic, source);
  choice.image = options.image_topic.empty()
                     ? FindImage(topics, source)
                     : std::optional<size_t>(NamedImage(topics, options.image_topic, source));
  if (choice.image) choice.camera_info = FindCameraInfo(topics, BaseOf(topics[*choice.image]));
  for (size_t k = 0; k < topics.size(); ++k) {
    if (KindOf(topics[k]) != MessageKind::kTransforms) continue;
    (EndsWith(topics[k].name, "tf_static") ? choice.static_transforms : choice.moving_transforms)
        .push_back(k);
  }
  return choice;
}

}  // namespace tvl
