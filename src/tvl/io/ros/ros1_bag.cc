#include "tvl/io/ros/ros1_bag.h"

#include <algorithm>
#include <cstring>

#include "tvl/base/check.h"

namespace tvl {
namespace {

constexpr std::string_view kAnyVersion = "#ROSBAG V";
constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
// Enough for a record header and a few index entries, little enough to be read for every chunk.
constexpr size_t kSmallWindowBytes = 1024;
// For walks through many records.
constexpr size_t kLargeWindowBytes = size_t{1} << 18;
// A message record's header takes about 50 bytes: what is read first of a message.
constexpr size_t kMessageStartBytes = 256;
// However well a chunk is compressed, the time of a message takes this much. It bounds the memory
// that a small file can make the index take.
constexpr uint64_t kLeastMessageBytes = 2;
// One entry of an index data record: time and offset.
constexpr size_t kIndexEntryBytes = 12;

bool StartsWith(const ByteSource& source, std::string_view text) {
  if (source.size() < text.size()) return false;
  const std::vector<uint8_t> start = source.Read(0, uint64_t{text.size()});
  return std::memcmp(start.data(), text.data(), text.size()) == 0;
}

// Empty where it is damaged: the bag may be scanned all the same.
std::optional<Ros1Record> ReadBagHeader(SourceCursor* cursor) {
  try {
    Ros1Record record = ReadRos1Record(cursor);
    record.fields.Number<uint64_t>("index_pos");
    return record;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

}  // namespace

bool IsRos1Bag(const ByteSource& source) { return StartsWith(source, kAnyVersion); }

Ros1Bag::Ros1Bag(const std::shared_ptr<const ByteSource>& source)
    : source_(source), chunks_(source) {
  const std::string& name = source_->name();
  TVL_CHECK_INPUT(StartsWith(*source_, kMagic))
      << name << ": not a ROS 1 bag of version 2.0; older ones are brought up to it with "
      << "'rosbag fix'";
  SourceCursor cursor(*source_, kMagic.size(), source_->size(), kSmallWindowBytes);
  const std::optional<Ros1Record> header = ReadBagHeader(&cursor);
  TVL_CHECK_INPUT(!header || header->fields.Text("encryptor").empty())
      << name << ": the bag is encrypted; decrypt it first with 'rosbag decrypt'";
  const bool indexed = header && OpenByIndex(header->fields.Number<uint64_t>("index_pos"));
  if (!indexed) ScanFile(kMagic.size());
  topics_ = connections_.Topics(true);
  topic_of_connection_ = connections_.Positions();
}

bool Ros1Bag::OpenByIndex(uint64_t index_offset) {
  if (index_offset == 0) return false;  // never closed
  RepeatedWarning outside;
  try {
    SourceCursor cursor(*source_, index_offset, source_->size(), kLargeWindowBytes);
    while (cursor.remaining() > 0) {
      const Ros1Record record = ReadRos1Record(&cursor);
      const uint64_t end = record.data_offset + record.data_bytes;
      TVL_CHECK_INPUT(record.data_bytes <= cursor.remaining()) << source_->name() << ": cut off";
      if (record.fields.Op() == Ros1Op::kConnection) AddConnection(record, &cursor);
      if (record.fields.Op() == Ros1Op::kChunkInfo) AddChunkInfo(record, &cursor, &outside);
      cursor.Skip(end - cursor.position());
    }
  } catch (const InputError&) {
    connections_ = TopicList();  // the scan finds out what there is
  }
  if (!connections_.empty() && outside.count() == 0 && ChunksAreInOrder()) return true;
  connections_ = TopicList();
  chunk_entries_.clear();
  chunks_.Clear();
  return false;
}

// Chunks that overlap would let a small file announce any number of messages.
bool Ros1Bag::ChunksAreInOrder() {
  std::sort(chunk_entries_.begin(), chunk_entries_.end(),
            [](const ChunkEntry& a, const ChunkEntry& b) { return a.begin < b.begin; });
  for (size_t k = 0; k + 1 < chunk_entries_.size(); ++k) {
    chunk_entries_[k].index_end = chunk_entries_[k + 1].begin;
    if (chunk_entries_[k].index_end < chunk_entries_[k].index_offset) return false;
  }
  return true;
}

void Ros1Bag::AddConnection(const Ros1Record& record, SourceCursor* cursor) {
  const auto id = record.fields.Number<uint32_t>("conn");
  const std::string name = record.fields.Text("topic");
  const Ros1Fields described(cursor->Peek(record.data_bytes), record.data_bytes, source_->name());
  connections_.Add(id, {name, described.Text("type"), MessageEncoding::kRos1, {}});
}

uint32_t Ros1Bag::AddChunk(const Ros1Record& record) {
  const std::string& name = source_->name();
  const uint64_t left = source_->size() - std::min(record.data_offset, source_->size());
  return chunks_.Add({record.data_offset, std::min<uint64_t>(record.data_bytes, left),
                      record.fields.Number<uint32_t>("size"),
                      CompressionByName(record.fields.Text("compression"), name)});
}

void Ros1Bag::AddChunkInfo(const Ros1Record& info, SourceCursor* cursor, RepeatedWarning* outside) {
  WireReader reader(cursor->Peek(info.data_bytes), info.data_bytes, MessageEncoding::kRos1,
                    source_->name());
  const auto chunk_offset = info.fields.Number<uint64_t>("chunk_pos");
  std::vector<uint32_t> connections;
  while (reader.remaining() > 0) {
    connections.push_back(reader.Number<uint32_t>());
    connections_.Count(connections.back(), reader.Number<uint32_t>());
  }
  try {
    SourceCursor at_chunk(*source_, chunk_offset, source_->size(), kSmallWindowBytes);
    const Ros1Record record = ReadRos1Record(&at_chunk);
    TVL_CHECK_INPUT(record.fields.Op() == Ros1Op::kChunk)
        << source_->name() << ": byte " << chunk_offset << ": no chunk, though the index says so";
    at_chunk.Skip(record.data_bytes);
    chunk_entries_.push_back({AddChunk(record), chunk_offset, at_chunk.position(), source_->size(),
                              std::move(connections)});
  } catch (const InputError& error) {
    outside->Add(error.what());
  }
}

void Ros1Bag::ScanFile(uint64_t begin) {
  warnings_.push_back(source_->name() +
                      ": no usable index: the bag was not closed or is cut off; scanned from start "
                      "to end ('rosbag reindex' mends it)");
  SourceCursor cursor(*source_, begin, source_->size(), kSmallWindowBytes);
  try {
    ScanRecords(&cursor);
  } catch (const InputError& error) {
    warnings_.push_back(std::string(error.what()) + "; what comes before byte " +
                        std::to_string(cursor.position()) + " is used");
  }
  for (const auto& [id, messages] : scanned_messages_) connections_.Count(id, messages.size());
}

void Ros1Bag::ScanRecords(SourceCursor* cursor) {
  while (cursor->remaining() > 0) {
    const Ros1Record record = ReadRos1Record(cursor);
    if (record.fields.Op() == Ros1Op::kChunk) ScanChunk(AddChunk(record));
    if (record.fields.Op() == Ros1Op::kConnection) AddConnection(record, cursor);
    cursor->Skip(record.data_bytes);
  }
}

void Ros1Bag::ScanChunk(uint32_t number) {
  const Chunk& chunk = chunks_.chunk(number);
  try {
    if (chunk.compression == Compression::kNone) {
      SourceCursor cursor(*source_, chunk.offset, chunk.offset + chunk.stored_bytes,
                          kLargeWindowBytes);
      ScanMessages(number, &cursor);
    } else {
      const MessageBytes inflated = chunks_.ReadUpTo(number, 0, chunk.inflated_bytes, false);
      const auto memory = MemorySource(chunks_.Place(number, 0), inflated.data, inflated.size);
      SourceCursor cursor(*memory, 0, inflated.size, inflated.size);
      ScanMessages(number, &cursor);
      TVL_CHECK_INPUT(inflated.size == chunk.inflated_bytes)
          << chunks_.Place(number, inflated.size) << ": cut off or damaged";
    }
  } catch (const InputError& error) {
    warnings_.push_back(std::string(error.what()) + "; what comes before it is used");
  }
}

void Ros1Bag::ScanMessages(uint32_t number, SourceCursor* cursor) {
  const bool in_file = chunks_.chunk(number).compression == Compression::kNone;
  const uint64_t base = in_file ? chunks_.chunk(number).offset : 0;
  while (cursor->remaining() > 0) {
    const uint64_t begin = cursor->position() - base;
    const Ros1Record record = ReadRos1Record(cursor);
    const Ros1Op op = record.fields.Op();
    if (op == Ros1Op::kConnection) AddConnection(record, cursor);
    cursor->Skip(record.data_bytes);
    if (op != Ros1Op::kMessage) continue;
    const auto id = record.fields.Number<uint32_t>("conn");
    TVL_CHECK_INPUT(++scanned_count_ <= source_->size() / kLeastMessageBytes)
        << cursor->source().name() << ": more messages than a file of this size can hold";
    scanned_messages_[id].push_back({record.fields.Time("time"), begin, number, 0});
  }
}

void Ros1Bag::ReadIndex(const ChunkEntry& entry, const Wanted& wanted) const {
  SourceCursor cursor(*source_, entry.index_offset, entry.index_end, kSmallWindowBytes);
  size_t found = 0;
  while (found < entry.connections.size() && cursor.remaining() > 0) {
    const Ros1Record record = ReadRos1Record(&cursor);
    if (record.fields.Op() != Ros1Op::kIndexData) break;
    ++found;
    const auto target = wanted.find(record.fields.Number<uint32_t>("conn"));
    if (target == wanted.end()) {
      cursor.Skip(record.data_bytes);
      continue;
    }
    WireReader reader(cursor.Take(record.data_bytes), record.data_bytes, MessageEncoding::kRos1,
                      source_->name());
    while (reader.remaining() >= kIndexEntryBytes) {
      const int64_t seconds = reader.Number<uint32_t>();
      const int64_t nanoseconds = reader.Number<uint32_t>();
      const uint64_t offset = reader.Number<uint32_t>();
      TVL_CHECK_INPUT(offset < chunks_.chunk(entry.chunk).inflated_bytes)
          << chunks_.Place(entry.chunk, offset) << ": the index names a message beyond the chunk";
      target->second->push_back({{seconds * 1'000'000'000 + nanoseconds}, offset, entry.chunk, 0});
    }
  }
  TVL_CHECK_INPUT(found == entry.connections.size())
      << chunks_.Place(entry.chunk, 0) << ": a part of its index is missing, with its messages";
}

MessageIndex Ros1Bag::Index(const std::vector<size_t>& topics) const {
  MessageIndex index;
  index.topics.resize(topics.size());
  Wanted wanted;
  for (const auto& [id, topic] : topic_of_connection_) {
    const auto found = std::find(topics.begin(), topics.end(), topic);
    if (found == topics.end()) continue;
    wanted[id] = &index.topics[static_cast<size_t>(found - topics.begin())];
  }
  RepeatedWarning damaged;
  for (const ChunkEntry& entry : chunk_entries_) {
    const bool any = std::any_of(entry.connections.begin(), entry.connections.end(),
                                 [&](uint32_t id) { return wanted.count(id) > 0; });
    if (!any) continue;
    try {
      ReadIndex(entry, wanted);
    } catch (const InputError& error) {
      damaged.Add(error.what());
    }
  }
  for (const auto& [id, messages] : scanned_messages_) {
    const auto target = wanted.find(id);
    if (target == wanted.end()) continue;
    target->second->insert(target->second->end(), messages.begin(), messages.end());
  }
  damaged.MoveTo(&index.warnings);
  for (std::vector<MessageLocation>& messages : index.topics) SortByLogTime(&messages);
  return index;
}

MessageBytes Ros1Bag::Message(const MessageLocation& location, const MessageBytes& start,
                              bool start_only) const {
  const auto memory =
      MemorySource(chunks_.Place(location.block, location.offset), start.data, start.size);
  SourceCursor cursor(*memory, 0, start.size, start.size);
  const Ros1Record record = ReadRos1Record(&cursor);
  TVL_CHECK_INPUT(record.fields.Op() == Ros1Op::kMessage)
      << memory->name() << ": no message, though the index says so";
  if (start_only || record.data_bytes <= cursor.remaining()) {
    const uint64_t bytes = std::min<uint64_t>(record.data_bytes, cursor.remaining());
    return {start.owner, start.data + record.data_offset, bytes};
  }
  return chunks_.Read(location.block, location.offset + record.data_offset, record.data_bytes);
}

MessageBytes Ros1Bag::Read(const MessageLocation& location) const {
  return Message(location,
                 chunks_.ReadUpTo(location.block, location.offset, kMessageStartBytes, false),
                 false);
}

MessageBytes Ros1Bag::ReadStart(const MessageLocation& location, size_t bytes) const {
  MessageBytes start = Message(
      location, chunks_.ReadUpTo(location.block, location.offset, bytes + kMessageStartBytes, true),
      true);
  start.size = std::min(start.size, bytes);
  return start;
}

std::string Ros1Bag::Describe() const {
  return "ROS 1 bag, chunk compression " + chunks_.CompressionNames();
}

}  // namespace tvl
