#include "tvl/io/ros/split_store.h"

#include <set>

#include "tvl/io/ros/topic_list.h"

namespace tvl {
namespace {

bool IsSame(const MessageTopic& a, const MessageTopic& b) {
  return a.name == b.name && a.type == b.type && a.encoding == b.encoding;
}

}  // namespace

SplitStore::SplitStore(std::vector<std::unique_ptr<MessageStore>> parts)
    : parts_(std::move(parts)) {
  TopicList list;
  uint32_t id = 0;
  bool counted = true;
  for (const auto& part : parts_) {
    for (const MessageTopic& topic : part->topics()) {
      list.Add(id, topic);
      counted = counted && topic.count.has_value();
      list.Count(id++, topic.count.value_or(0));
    }
    const std::vector<std::string>& more = part->warnings();
    warnings_.insert(warnings_.end(), more.begin(), more.end());
  }
  topics_ = list.Topics(true);
  for (MessageTopic& topic : topics_) {
    if (!counted) topic.count.reset();
  }
}

MessageIndex SplitStore::Index(const std::vector<size_t>& topics) const {
  MessageIndex index;
  index.topics.resize(topics.size());
  for (size_t part = 0; part < parts_.size(); ++part) {
    const std::vector<MessageTopic>& there = parts_[part]->topics();
    std::vector<size_t> wanted, targets;
    for (size_t k = 0; k < topics.size(); ++k) {
      for (size_t j = 0; j < there.size(); ++j) {
        if (!IsSame(topics_.at(topics[k]), there[j])) continue;
        wanted.push_back(j), targets.push_back(k);
      }
    }
    MessageIndex found = parts_[part]->Index(wanted);
    for (size_t k = 0; k < wanted.size(); ++k) {
      for (MessageLocation location : found.topics[k]) {
        location.part = static_cast<uint32_t>(part);
        index.topics[targets[k]].push_back(location);
      }
    }
    index.warnings.insert(index.warnings.end(), found.warnings.begin(), found.warnings.end());
  }
  for (std::vector<MessageLocation>& messages : index.topics) SortByLogTime(&messages);
  return index;
}

MessageBytes SplitStore::Read(const MessageLocation& location) const {
  return parts_.at(location.part)->Read(location);
}

MessageBytes SplitStore::ReadStart(const MessageLocation& location, size_t bytes) const {
  return parts_.at(location.part)->ReadStart(location, bytes);
}

std::string SplitStore::Describe() const {
  std::set<std::string> kinds;
  for (const auto& part : parts_) kinds.insert(part->Describe());
  std::string text = std::to_string(parts_.size()) + " files:";
  for (const std::string& kind : kinds) text += " " + kind;
  return text;
}

}  // namespace tvl
