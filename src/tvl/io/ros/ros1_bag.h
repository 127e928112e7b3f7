// ROS 1 bags, format 2.0 (wiki.ros.org/Bags/Format/2.0).
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tvl/io/ros/chunk_reader.h"
#include "tvl/io/ros/message_store.h"
#include "tvl/io/ros/ros1_record.h"
#include "tvl/io/ros/topic_list.h"

namespace tvl {

// True for any version, also those that cannot be read.
bool IsRos1Bag(const ByteSource& source);

// Opens by the index at the end of the file: a few reads a chunk. Without one (not closed, cut off)
// the file is scanned once, and everything up to the break is delivered.
class Ros1Bag : public MessageStore {
 public:
  // Throws InputError for other formats and versions, and for encrypted bags.
  explicit Ros1Bag(const std::shared_ptr<const ByteSource>& source);

  const std::vector<MessageTopic>& topics() const override { return topics_; }
  MessageIndex Index(const std::vector<size_t>& topics) const override;
  MessageBytes Read(const MessageLocation& location) const override;
  MessageBytes ReadStart(const MessageLocation& location, size_t bytes) const override;
  std::string Describe() const override;
  const std::vector<std::string>& warnings() const override { return warnings_; }

 private:
  struct ChunkEntry {
    uint32_t chunk;
    uint64_t begin;                     // of the chunk's record in the file
    uint64_t index_offset, index_end;   // records of kind index data, behind the chunk
    std::vector<uint32_t> connections;  // that have messages in the chunk
  };
  // Topic of a connection -> place in the answer of Index.
  using Wanted = std::map<uint32_t, std::vector<MessageLocation>*>;

  // False where there is no usable index.
  bool OpenByIndex(uint64_t index_offset);
  bool ChunksAreInOrder();
  void AddConnection(const Ros1Record& record, SourceCursor* cursor);
  void AddChunkInfo(const Ros1Record& record, SourceCursor* cursor, RepeatedWarning* outside);
  uint32_t AddChunk(const Ros1Record& record);
  void ScanFile(uint64_t begin);
  void ScanRecords(SourceCursor* cursor);
  void ScanChunk(uint32_t chunk);
  void ScanMessages(uint32_t chunk, SourceCursor* cursor);
  void ReadIndex(const ChunkEntry& entry, const Wanted& wanted) const;
  MessageBytes Message(const MessageLocation& location, const MessageBytes& start,
                       bool start_only) const;

  std::shared_ptr<const ByteSource> source_;
  ChunkReader chunks_;
  TopicList connections_;
  std::vector<ChunkEntry> chunk_entries_;  // by the index
  uint64_t scanned_count_ = 0;
  std::map<uint32_t, std::vector<MessageLocation>> scanned_messages_;  // by connection
  std::vector<MessageTopic> topics_;
  std::map<uint32_t, size_t> topic_of_connection_;
  std::vector<std::string> warnings_;
};

}  // namespace tvl
