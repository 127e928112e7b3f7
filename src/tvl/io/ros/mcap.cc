#include "tvl/io/ros/mcap.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "tvl/base/check.h"

namespace tvl {
namespace {

constexpr std::array<uint8_t, 8> kMagic = {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
// Opcode and length of every record.
constexpr uint64_t kRecordHeadBytes = 9;
// Footer: two offsets and a checksum.
constexpr uint64_t kFooterBytes = 20;
// Channel, sequence number and two times before the data of a message.
constexpr uint64_t kMessageHeadBytes = 22;
// Of a chunk before the text of its compression: two times, size, checksum, length of the text.
constexpr uint64_t kChunkHeadBytes = 32;
// However well a chunk is compressed, the time of a message takes this much. It bounds the memory
// that a small file can make the index take.
constexpr uint64_t kLeastMessageBytes = 2;
// One entry of a message index: time and offset.
constexpr size_t kIndexEntryBytes = 16;
// The block of messages that are in no chunk.
constexpr uint32_t kWholeFile = 0;
// Enough for the heads of records, little enough to be read for every message.
constexpr size_t kSmallWindowBytes = 1024;
constexpr size_t kLargeWindowBytes = size_t{1} << 18;
// Schemas, channels and chunk indexes are small; a larger record is damaged.
constexpr uint64_t kMostIndexRecordBytes = uint64_t{1} << 24;

enum Opcode : uint8_t {
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kDataEnd = 0x0F,
};

struct RecordHead {
  uint8_t opcode;
  uint64_t bytes;  // of what follows, as announced
};

RecordHead TakeHead(SourceCursor* cursor) {
  WireReader reader(cursor->Take(kRecordHeadBytes), kRecordHeadBytes, MessageEncoding::kRos1,
                    cursor->source().name());
  const auto opcode = reader.Number<uint8_t>();
  return {opcode, reader.Number<uint64_t>()};
}

WireReader TakeRecord(SourceCursor* cursor, uint64_t bytes) {
  TVL_CHECK_INPUT(bytes <= kMostIndexRecordBytes)
      << cursor->source().name() << ": byte " << cursor->position() << ": a record of " << bytes
      << " bytes where small ones are expected: damaged";
  return {cursor->Take(bytes), static_cast<size_t>(bytes), MessageEncoding::kRos1,
          cursor->source().name()};
}

MessageEncoding EncodingOf(const std::string& message_encoding) {
  if (message_encoding == "cdr") return MessageEncoding::kCdr;
  if (message_encoding == "ros1") return MessageEncoding::kRos1;
  return MessageEncoding::kOther;
}

Timestamp TakeTime(WireReader* reader) {
  return {static_cast<int64_t>(reader->Number<uint64_t>())};
}

}  // namespace

// What the summary says beside schemas and channels.
struct Mcap::Summary {
  bool has_statistics = false;
  uint64_t messages = 0;  // in all
  std::map<uint16_t, uint64_t> channel_messages;
};

bool IsMcap(const ByteSource& source) {
  if (source.size() < kMagic.size()) return false;
  const std::vector<uint8_t> start = source.Read(0, uint64_t{kMagic.size()});
  return std::equal(kMagic.begin(), kMagic.end(), start.begin());
}

Mcap::Mcap(const std::shared_ptr<const ByteSource>& source) : source_(source), chunks_(source) {
  TVL_CHECK_INPUT(IsMcap(*source_)) << source_->name() << ": not an MCAP file";
  chunks_.Add({0, source_->size(), source_->size(), Compression::kNone});
  try {
    OpenBySummary();
  } catch (const InputError& error) {
    ScanFile(error.what());
  }
  topic_of_channel_ = channels_.Positions();
}

void Mcap::OpenBySummary() {
  const std::string& name = source_->name();
  constexpr uint64_t kTailBytes = kRecordHeadBytes + kFooterBytes + kMagic.size();
  TVL_CHECK_INPUT(source_->size() >= kMagic.size() + kTailBytes) << name << ": cut off";
  const uint64_t footer_begin = source_->size() - kTailBytes;
  SourceCursor cursor(*source_, footer_begin, source_->size(), kTailBytes);
  const RecordHead head = TakeHead(&cursor);
  TVL_CHECK_INPUT(head.opcode == kFooter && head.bytes == kFooterBytes)
      << name << ": no footer: the file was not closed or is cut off";
  const auto summary_begin = TakeRecord(&cursor, kFooterBytes).Number<uint64_t>();
  TVL_CHECK_INPUT(summary_begin != 0) << name << ": no summary";
  TVL_CHECK_INPUT(summary_begin <= footer_begin) << name << ": the summary lies beyond the end";
  Summary summary;
  ReadSummary(summary_begin, footer_begin, &summary);
  CheckChunkEntries();
  TVL_CHECK_INPUT(!chunk_entries_.empty() || (summary.has_statistics && summary.messages == 0))
      << name << ": messages without an index";
  TVL_CHECK_INPUT(!channels_.empty() || summary.messages == 0) << name << ": channels not indexed";
  for (const auto& [channel, count] : summary.channel_messages) channels_.Count(channel, count);
  topics_ = channels_.Topics(summary.has_statistics);
}

// Chunks that overlap would let a small file announce any number of messages.
void Mcap::CheckChunkEntries() {
  std::sort(
      chunk_entries_.begin(), chunk_entries_.end(),
      [](const ChunkEntry& a, const ChunkEntry& b) { return a.index_offset < b.index_offset; });
  uint64_t end = 0;
  for (const ChunkEntry& entry : chunk_entries_) {
    const uint64_t begin = chunks_.chunk(entry.chunk).offset;
    const bool indexed = !entry.channels.empty() && entry.index_bytes > 0;
    TVL_CHECK_INPUT(indexed || chunks_.chunk(entry.chunk).inflated_bytes == 0)
        << source_->name() << ": byte " << begin << ": a chunk without message index";
    TVL_CHECK_INPUT(begin >= end) << source_->name() << ": byte " << begin << ": chunks overlap";
    end = entry.index_offset + entry.index_bytes;
  }
}

void Mcap::ReadSummary(uint64_t begin, uint64_t end, Summary* summary) {
  SourceCursor cursor(*source_, begin, end, kLargeWindowBytes);
  while (cursor.remaining() > 0) {
    const RecordHead head = TakeHead(&cursor);
    if (head.opcode != kSchema && head.opcode != kChannel && head.opcode != kChunkIndex &&
        head.opcode != kStatistics) {
      cursor.Skip(head.bytes);
      continue;
    }
    WireReader record = TakeRecord(&cursor, head.bytes);
    if (head.opcode == kSchema) AddSchema(&record);
    if (head.opcode == kChannel) AddChannel(&record);
    if (head.opcode == kChunkIndex) chunk_entries_.push_back(ReadChunkIndex(&record));
    if (head.opcode != kStatistics) continue;
    summary->has_statistics = true;
    summary->messages = record.Number<uint64_t>();
    record.Bytes(2 + 4 + 4 + 4 + 4 + 8 + 8);  // numbers of other records, first and last time
    const uint32_t map_bytes = record.Count(1);
    for (uint32_t k = 0; k + 10 <= map_bytes; k += 10) {
      const auto channel = record.Number<uint16_t>();
      summary->channel_messages[channel] = record.Number<uint64_t>();
    }
  }
}

void Mcap::AddSchema(WireReader* record) {
  const auto id = record->Number<uint16_t>();
  std::string name = record->String();
  schemas_.emplace(id, Schema{std::move(name), record->String()});
}

void Mcap::AddChannel(WireReader* record) {
  const auto id = record->Number<uint16_t>();
  const auto schema = schemas_.find(record->Number<uint16_t>());
  std::string topic = record->String();
  const MessageEncoding encoding = EncodingOf(record->String());
  channels_.Add(
      id, {std::move(topic), schema == schemas_.end() ? "" : schema->second.name, encoding, {}});
}

Mcap::ChunkEntry Mcap::ReadChunkIndex(WireReader* record) {
  TakeTime(record), TakeTime(record);  // of the first and the last message
  const auto chunk_begin = record->Number<uint64_t>();
  const auto chunk_bytes = record->Number<uint64_t>();
  ChunkEntry entry{};
  const uint32_t map_bytes = record->Count(1);
  for (uint32_t k = 0; k + 10 <= map_bytes; k += 10) {
    entry.channels.push_back(record->Number<uint16_t>());
    record->Number<uint64_t>();  // where its index is: all of them are read at once
  }
  entry.index_bytes = record->Number<uint64_t>();
  const std::string compression = record->String();
  const auto stored_bytes = record->Number<uint64_t>();
  const auto inflated_bytes = record->Number<uint64_t>();
  const uint64_t head_bytes = kRecordHeadBytes + kChunkHeadBytes + compression.size() + 8;
  TVL_CHECK_INPUT(chunk_begin <= source_->size() && chunk_bytes <= source_->size() - chunk_begin &&
                  head_bytes <= chunk_bytes && stored_bytes <= chunk_bytes - head_bytes &&
                  entry.index_bytes <= source_->size() - chunk_begin - chunk_bytes)
      << source_->name() << ": the chunk at byte " << chunk_begin << " of " << chunk_bytes
      << " bytes does not fit into the file or its own sizes";
  entry.index_offset = chunk_begin + chunk_bytes;
  entry.chunk = chunks_.Add({chunk_begin + head_bytes, stored_bytes, inflated_bytes,
                             CompressionByName(compression, source_->name())});
  return entry;
}

void Mcap::ReadMessageIndex(const ChunkEntry& entry, const Wanted& wanted) const {
  SourceCursor cursor(*source_, entry.index_offset, entry.index_offset + entry.index_bytes,
                      kLargeWindowBytes);
  while (cursor.remaining() > 0) {
    const RecordHead head = TakeHead(&cursor);
    TVL_CHECK_INPUT(head.opcode == kMessageIndex)
        << source_->name() << ": byte " << cursor.position() << ": no message index, though the "
        << "summary says so";
    WireReader record = TakeRecord(&cursor, head.bytes);
    const auto target = wanted.find(record.Number<uint16_t>());
    const uint32_t count = record.Count(1) / kIndexEntryBytes;
    if (target == wanted.end()) continue;
    for (uint32_t k = 0; k < count; ++k) {
      const Timestamp time = TakeTime(&record);
      const auto offset = record.Number<uint64_t>();
      TVL_CHECK_INPUT(offset < chunks_.chunk(entry.chunk).inflated_bytes)
          << chunks_.Place(entry.chunk, offset) << ": the index names a message beyond the chunk";
      target->second->push_back({time, offset, entry.chunk, 0});
    }
  }
}

MessageIndex Mcap::Index(const std::vector<size_t>& topics) const {
  MessageIndex index;
  index.topics.resize(topics.size());
  Wanted wanted;
  for (const auto& [channel, topic] : topic_of_channel_) {
    const auto found = std::find(topics.begin(), topics.end(), topic);
    if (found == topics.end()) continue;
    wanted[channel] = &index.topics[static_cast<size_t>(found - topics.begin())];
  }
  RepeatedWarning damaged;
  for (const ChunkEntry& entry : chunk_entries_) {
    const bool any = std::any_of(entry.channels.begin(), entry.channels.end(),
                                 [&](uint16_t channel) { return wanted.count(channel) > 0; });
    if (!any) continue;
    try {
      ReadMessageIndex(entry, wanted);
    } catch (const InputError& error) {
      damaged.Add(error.what());
    }
  }
  for (const auto& [channel, messages] : scanned_messages_) {
    const auto target = wanted.find(channel);
    if (target == wanted.end()) continue;
    target->second->insert(target->second->end(), messages.begin(), messages.end());
  }
  damaged.MoveTo(&index.warnings);
  for (std::vector<MessageLocation>& messages : index.topics) SortByLogTime(&messages);
  return index;
}

void Mcap::ScanFile(const std::string& why) {
  channels_ = TopicList();
  schemas_.clear(), chunk_entries_.clear(), chunks_.Clear();
  chunks_.Add({0, source_->size(), source_->size(), Compression::kNone});
  warnings_.push_back(why + "; scanned from start to end ('mcap recover' mends it)");
  SourceCursor cursor(*source_, kMagic.size(), source_->size(), kSmallWindowBytes);
  try {
    ScanRecords(&cursor, kWholeFile);
  } catch (const InputError& error) {
    warnings_.push_back(std::string(error.what()) + "; what comes before byte " +
                        std::to_string(cursor.position()) + " is used");
  }
  for (const auto& [channel, messages] : scanned_messages_) {
    channels_.Count(channel, messages.size());
  }
  topics_ = channels_.Topics(true);
}

void Mcap::ScanRecords(SourceCursor* cursor, uint32_t block) {
  // A chunk that is not compressed is walked in the file itself: its offsets count from its start.
  const uint64_t base =
      &cursor->source() == source_.get() && block != kWholeFile ? chunks_.chunk(block).offset : 0;
  while (cursor->remaining() > 0) {
    const uint64_t begin = cursor->position() - base;
    const RecordHead head = TakeHead(cursor);
    if (head.opcode == kDataEnd || head.opcode == kFooter) return;
    if (head.opcode == kSchema || head.opcode == kChannel) {
      WireReader record = TakeRecord(cursor, head.bytes);
      head.opcode == kSchema ? AddSchema(&record) : AddChannel(&record);
    } else if (head.opcode == kMessage && head.bytes >= kMessageHeadBytes) {
      WireReader record(cursor->Peek(kMessageHeadBytes), kMessageHeadBytes, MessageEncoding::kRos1,
                        cursor->source().name());
      const auto channel = record.Number<uint16_t>();
      record.Number<uint32_t>();  // sequence number
      const Timestamp log_time = TakeTime(&record);
      cursor->Skip(head.bytes);
      TVL_CHECK_INPUT(++scanned_count_ <= source_->size() / kLeastMessageBytes)
          << cursor->source().name() << ": more messages than a file of this size can hold";
      scanned_messages_[channel].push_back({log_time, begin, block, 0});
    } else if (head.opcode == kChunk && block == kWholeFile) {
      ScanChunk(cursor, head.bytes);
    } else {
      cursor->Skip(head.bytes);
    }
  }
}

void Mcap::ScanChunk(SourceCursor* cursor, uint64_t bytes) {
  const uint64_t begin = cursor->position();
  WireReader head(cursor->Take(kChunkHeadBytes), kChunkHeadBytes, MessageEncoding::kRos1,
                  source_->name());
  TakeTime(&head), TakeTime(&head);
  const auto inflated_bytes = head.Number<uint64_t>();
  head.Number<uint32_t>();  // checksum
  const auto name_bytes = head.Number<uint32_t>();
  TVL_CHECK_INPUT(name_bytes <= kSmallWindowBytes)
      << source_->name() << ": byte " << begin << ": damaged chunk";
  const uint8_t* name = cursor->Take(name_bytes);
  const Compression compression = CompressionByName(
      std::string(reinterpret_cast<const char*>(name), name_bytes), source_->name());
  WireReader length(cursor->Take(8), 8, MessageEncoding::kRos1, source_->name());
  const uint64_t stored = std::min(length.Number<uint64_t>(), cursor->remaining());
  const uint64_t offset = cursor->position();
  const uint32_t number = chunks_.Add({offset, stored, inflated_bytes, compression});
  try {
    if (compression == Compression::kNone) {
      SourceCursor inside(*source_, offset, offset + stored, kLargeWindowBytes);
      ScanRecords(&inside, number);
    } else {
      const MessageBytes inflated = chunks_.ReadUpTo(number, 0, inflated_bytes, false);
      const auto memory = MemorySource(chunks_.Place(number, 0), inflated.data, inflated.size);
      SourceCursor inside(*memory, 0, inflated.size, inflated.size);
      ScanRecords(&inside, number);
      TVL_CHECK_INPUT(inflated.size == inflated_bytes)
          << chunks_.Place(number, inflated.size) << ": cut off or damaged";
    }
  } catch (const InputError& error) {
    warnings_.push_back(std::string(error.what()) + "; what comes before it is used");
  }
  TVL_CHECK_INPUT(bytes >= offset - begin)
      << source_->name() << ": byte " << begin << ": damaged chunk";
  cursor->Skip(bytes - (offset - begin));
}

MessageBytes Mcap::Data(const MessageLocation& location, uint64_t most_bytes,
                        bool start_only) const {
  constexpr uint64_t kHeadBytes = kRecordHeadBytes + kMessageHeadBytes;
  const uint64_t first_bytes = kHeadBytes + std::min<uint64_t>(most_bytes, kSmallWindowBytes);
  MessageBytes start = chunks_.ReadUpTo(location.block, location.offset, first_bytes, start_only);
  const std::string place = chunks_.Place(location.block, location.offset);
  WireReader head(start.data, start.size, MessageEncoding::kRos1, place);
  const auto opcode = head.Number<uint8_t>();
  const auto bytes = head.Number<uint64_t>();
  TVL_CHECK_INPUT(opcode == kMessage && bytes >= kMessageHeadBytes)
      << place << ": no message, though the index says so";
  head.Bytes(kMessageHeadBytes);
  const uint64_t data_bytes = std::min(bytes - kMessageHeadBytes, most_bytes);
  if (start_only || data_bytes <= head.remaining()) {
    return {start.owner, start.data + kHeadBytes, std::min<size_t>(data_bytes, head.remaining())};
  }
  return chunks_.Read(location.block, location.offset + kHeadBytes, data_bytes);
}

MessageBytes Mcap::Read(const MessageLocation& location) const {
  return Data(location, UINT64_MAX, false);
}

MessageBytes Mcap::ReadStart(const MessageLocation& location, size_t bytes) const {
  return Data(location, bytes, true);
}

std::string Mcap::Describe() const {
  const bool chunked = chunks_.size() > 1;
  return "MCAP file, " + (chunked ? "chunk compression " + chunks_.CompressionNames(kWholeFile + 1)
                                  : std::string("no chunks"));
}

}  // namespace tvl
