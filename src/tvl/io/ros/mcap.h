// MCAP files (mcap.dev/spec).
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tvl/io/ros/chunk_reader.h"
#include "tvl/io/ros/message_store.h"
#include "tvl/io/ros/topic_list.h"

namespace tvl {

bool IsMcap(const ByteSource& source);

// Opens by the summary at the end of the file. Without one (not closed, cut off, written without
// chunks or indexes) the file is scanned once, and everything up to the break is delivered.
// Checksums are not compared: compressed chunks have their own.
class Mcap : public MessageStore {
 public:
  // Throws InputError for other formats.
  explicit Mcap(const std::shared_ptr<const ByteSource>& source);

  const std::vector<MessageTopic>& topics() const override { return topics_; }
  MessageIndex Index(const std::vector<size_t>& topics) const override;
  MessageBytes Read(const MessageLocation& location) const override;
  MessageBytes ReadStart(const MessageLocation& location, size_t bytes) const override;
  std::string Describe() const override;
  const std::vector<std::string>& warnings() const override { return warnings_; }

 private:
  struct ChunkEntry {
    uint32_t chunk;
    uint64_t index_offset, index_bytes;  // message index records behind the chunk
    std::vector<uint16_t> channels;      // that have messages in the chunk
  };
  struct Summary;
  // Topic of a channel -> place in the answer of Index.
  using Wanted = std::map<uint32_t, std::vector<MessageLocation>*>;

  // Throws InputError that says why where there is no usable summary.
  void OpenBySummary();
  void CheckChunkEntries();
  void ReadSummary(uint64_t begin, uint64_t end, Summary* summary);
  void AddSchema(WireReader* record);
  void AddChannel(WireReader* record);
  ChunkEntry ReadChunkIndex(WireReader* record);
  void ReadMessageIndex(const ChunkEntry& entry, const Wanted& wanted) const;
  void ScanFile(const std::string& why);
  void ScanRecords(SourceCursor* cursor, uint32_t block);
  void ScanChunk(SourceCursor* cursor, uint64_t bytes);
  MessageBytes Data(const MessageLocation& location, uint64_t most_bytes, bool start_only) const;

  std::shared_ptr<const ByteSource> source_;
  ChunkReader chunks_;  // number 0 is the whole file: messages that are in no chunk
  struct Schema {
    std::string name, encoding;
  };
  std::map<uint32_t, Schema> schemas_;
  TopicList channels_;
  std::vector<ChunkEntry> chunk_entries_;                              // by the summary
  std::map<uint32_t, std::vector<MessageLocation>> scanned_messages_;  // by channel
  uint64_t scanned_count_ = 0;
  std::vector<MessageTopic> topics_;
  std::map<uint32_t, size_t> topic_of_channel_;
  std::vector<std::string> warnings_;
};

}  // namespace tvl
