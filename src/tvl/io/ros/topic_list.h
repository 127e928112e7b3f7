// Collects the topics of a bag from its connections or channels, of which several may be the same
// topic.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "tvl/io/ros/message_store.h"

namespace tvl {

// Connections are known by their number in the file. Topics are ordered by name, then type.
class TopicList {
 public:
  // Says what connection `id` carries; of one that is known already the first word counts.
  void Add(uint32_t id, MessageTopic topic) {
    if (connections_.count(id) > 0) return;
    topic.count.reset();
    const Key key(topic.name, topic.type, topic.encoding);
    connections_.emplace(id, key);
    topics_.emplace(key, std::move(topic));
  }
  bool Has(uint32_t id) const { return connections_.count(id) > 0; }
  bool empty() const { return connections_.empty(); }
  // Adds to the number of messages of a connection's topic.
  void Count(uint32_t id, uint64_t messages) {
    const auto found = connections_.find(id);
    if (found == connections_.end()) return;
    MessageTopic& topic = topics_.at(found->second);
    topic.count = topic.count.value_or(0) + messages;
  }
  // `counted`: topics that were never counted have no messages.
  std::vector<MessageTopic> Topics(bool counted) const {
    std::vector<MessageTopic> topics;
    topics.reserve(topics_.size());
    for (const auto& [key, topic] : topics_) {
      topics.push_back(topic);
      if (counted) topics.back().count = topic.count.value_or(0);
    }
    return topics;
  }
  // Connection -> position of its topic in Topics().
  std::map<uint32_t, size_t> Positions() const {
    std::map<uint32_t, size_t> positions;
    for (const auto& [id, key] : connections_) {
      const auto distance = std::distance(topics_.begin(), topics_.find(key));
      positions.emplace(id, static_cast<size_t>(distance));
    }
    return positions;
  }

 private:
  using Key = std::tuple<std::string, std::string, MessageEncoding>;
  std::map<Key, MessageTopic> topics_;
  std::map<uint32_t, Key> connections_;
};

// Orders by time, and what has the same time by its place in the file.
inline void SortByLogTime(std::vector<MessageLocation>* messages) {
  std::sort(messages->begin(), messages->end(), [](const auto& a, const auto& b) {
    return std::tie(a.log_time.ns, a.part, a.block, a.offset) <
           std::tie(b.log_time.ns, b.part, b.block, b.offset);
  });
}

// Warnings of which there may be millions: the first text and how many there were.
class RepeatedWarning {
 public:
  void Add(const std::string& text) {
    if (count_++ == 0) first_ = text;
  }
  size_t count() const { return count_; }
  void MoveTo(std::vector<std::string>* warnings) const {
    if (count_ == 0) return;
    const std::string more = " (and " + std::to_string(count_ - 1) + " more like it)";
    warnings->push_back(first_ + (count_ > 1 ? more : ""));
  }

 private:
  std::string first_;
  size_t count_ = 0;
};

}  // namespace tvl
