// The messages of topics in the order of their stamps.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "tvl/io/ros/message_store.h"
#include "tvl/io/ros/messages.h"

namespace tvl {

class MessageStream;

// One stream a topic, with the stamps of all messages. They are read together and side by side, so
// that a compressed chunk is inflated once, and only up to its last header. `file` is for texts;
// `messages` are those of the topics, one entry each.
std::vector<std::shared_ptr<MessageStream>> OpenStreams(
    const std::shared_ptr<const MessageStore>& store, const std::vector<MessageTopic>& topics,
    const std::vector<std::vector<MessageLocation>>& messages, const std::string& file);

// Const and safe to call from several threads.
class MessageStream {
 public:
  // Without stamps: OpenStreams makes streams.
  MessageStream(std::shared_ptr<const MessageStore> store, MessageTopic topic,
                const std::vector<MessageLocation>& messages, const std::string& file);

  size_t size() const { return entries_.size(); }
  // The header's stamp, or the log time where the header has none.
  Timestamp Stamp(size_t index) const { return entries_.at(index).stamp; }
  // Throws InputError naming file, topic and message.
  StoredMessage Read(size_t index) const;
  std::string Place(size_t index) const;
  const MessageTopic& topic() const { return topic_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

  // Earliest and latest, 0 and 0 of nothing.
  struct Span {
    Timestamp first, last;
  };
  Span StampSpan() const;
  Span LogSpan() const;
  // From now on the log times are the stamps.
  void UseLogTimes();

 private:
  struct Entry {
    MessageLocation location;
    Timestamp stamp;  // 0: none, or not readable
  };
  struct Position {
    MessageStream* stream;
    size_t index;
  };
  friend std::vector<std::shared_ptr<MessageStream>> OpenStreams(
      const std::shared_ptr<const MessageStore>&, const std::vector<MessageTopic>&,
      const std::vector<std::vector<MessageLocation>>&, const std::string&);
  static std::vector<Position> ByPlace(const std::vector<std::shared_ptr<MessageStream>>& streams);
  void ReadStamp(size_t index);
  // Log times take the place of stamps that are missing.
  void FillStamps();
  void SortByStamp();

  std::shared_ptr<const MessageStore> store_;
  MessageTopic topic_;
  std::string place_;  // file and topic
  std::vector<Entry> entries_;
  std::vector<std::string> warnings_;
};

}  // namespace tvl
