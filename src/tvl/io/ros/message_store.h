// What every bag format is to its readers: topics, an index of messages, and their bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tvl/base/time.h"
#include "tvl/io/ros/wire.h"

namespace tvl {

// No message and no chunk may be larger: 16 million points, the most a scan may have, of 16 bytes.
// It bounds the memory that a damaged file can make a reader use.
inline constexpr uint64_t kMostMessageBytes = uint64_t{1} << 28;

struct MessageTopic {
  std::string name;
  std::string type;  // as stored: sensor_msgs/PointCloud2 or sensor_msgs/msg/PointCloud2
  MessageEncoding encoding = MessageEncoding::kOther;
  std::optional<uint64_t> count;  // as the file says; empty where only reading would tell
};

// Where a message is. Only the store it came from knows what part, block and offset mean.
struct MessageLocation {
  Timestamp log_time;   // when it was recorded
  uint64_t offset = 0;  // of its record in the block, or its id
  uint32_t block = 0;   // chunk
  uint32_t part = 0;    // file of a split bag
};

// Bytes of a message within memory that is kept alive with them.
struct MessageBytes {
  std::shared_ptr<const std::vector<uint8_t>> owner;
  const uint8_t* data = nullptr;
  size_t size = 0;
};

struct MessageIndex {
  std::vector<std::vector<MessageLocation>> topics;  // as asked for, each ordered by log_time
  std::vector<std::string> warnings;                 // parts that could not be indexed
};

// Const and safe to call from several threads.
class MessageStore {
 public:
  virtual ~MessageStore() = default;
  // Ordered by name. One entry a name and type, however many publishers there were.
  virtual const std::vector<MessageTopic>& topics() const = 0;
  // Messages of the topics given by their positions in topics(). Damaged parts are left out, with a
  // warning each kind.
  virtual MessageIndex Index(const std::vector<size_t>& topics) const = 0;
  // The whole message. Throws InputError with file and offset if it cannot be read.
  virtual MessageBytes Read(const MessageLocation& location) const = 0;
  // Its first bytes, at most `bytes`, read without the rest where the format allows it.
  virtual MessageBytes ReadStart(const MessageLocation& location, size_t bytes) const = 0;
  // Format and compression, for people.
  virtual std::string Describe() const = 0;
  // Trouble found when the file was opened.
  virtual const std::vector<std::string>& warnings() const = 0;
};

}  // namespace tvl
