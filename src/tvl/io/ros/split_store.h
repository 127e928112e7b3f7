// Several bag files as one: the parts of a recording that was split by size or time.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tvl/io/ros/message_store.h"

namespace tvl {

// Topics of the same name, type and encoding become one; its messages are ordered by log time.
class SplitStore : public MessageStore {
 public:
  explicit SplitStore(std::vector<std::unique_ptr<MessageStore>> parts);

  const std::vector<MessageTopic>& topics() const override { return topics_; }
  MessageIndex Index(const std::vector<size_t>& topics) const override;
  MessageBytes Read(const MessageLocation& location) const override;
  MessageBytes ReadStart(const MessageLocation& location, size_t bytes) const override;
  std::string Describe() const override;
  const std::vector<std::string>& warnings() const override { return warnings_; }

 private:
  std::vector<std::unique_ptr<MessageStore>> parts_;
  std::vector<MessageTopic> topics_;
  std::vector<std::string> warnings_;
};

}  // namespace tvl
