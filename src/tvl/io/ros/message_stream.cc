#include "tvl/io/ros/message_stream.h"

#include <algorithm>
#include <thread>
#include <tuple>

#include "tvl/base/check.h"
#include "tvl/base/parallel.h"

namespace tvl {
namespace {

// The stamp, and in CDR the encapsulation header before it.
constexpr size_t kStartBytes = kStampBytes + 4;
// Chunks that are kept inflated are few: more threads would throw out each other's.
constexpr int kMostThreads = 4;
// Neighbours in the file, most of them in one chunk or two.
constexpr size_t kMessagesATime = 16;

}  // namespace

MessageStream::MessageStream(std::shared_ptr<const MessageStore> store, MessageTopic topic,
                             const std::vector<MessageLocation>& messages, const std::string& file)
    : store_(std::move(store)), topic_(std::move(topic)), place_(file + ": " + topic_.name) {
  entries_.reserve(messages.size());
  for (const MessageLocation& location : messages) entries_.push_back({location, {}});
}

std::vector<MessageStream::Position> MessageStream::ByPlace(
    const std::vector<std::shared_ptr<MessageStream>>& streams) {
  std::vector<Position> order;
  for (const std::shared_ptr<MessageStream>& stream : streams) {
    for (size_t k = 0; k < stream->size(); ++k) order.push_back({stream.get(), k});
  }
  const auto place = [](const Position& p) -> const MessageLocation& {
    return p.stream->entries_[p.index].location;
  };
  // The last message of a chunk first: the others then find the chunk inflated.
  std::sort(order.begin(), order.end(), [&place](const Position& a, const Position& b) {
    const MessageLocation &la = place(a), &lb = place(b);
    return std::tie(la.part, la.block, lb.offset) < std::tie(lb.part, lb.block, la.offset);
  });
  return order;
}

std::vector<std::shared_ptr<MessageStream>> OpenStreams(
    const std::shared_ptr<const MessageStore>& store, const std::vector<MessageTopic>& topics,
    const std::vector<std::vector<MessageLocation>>& messages, const std::string& file) {
  TVL_CHECK(topics.size() == messages.size());
  std::vector<std::shared_ptr<MessageStream>> streams;
  for (size_t k = 0; k < topics.size(); ++k) {
    streams.push_back(std::make_shared<MessageStream>(store, topics[k], messages[k], file));
  }
  const std::vector<MessageStream::Position> order = MessageStream::ByPlace(streams);
  const auto cores = static_cast<int>(std::thread::hardware_concurrency());
  const auto tasks =
      static_cast<int>(std::min(order.size() / kMessagesATime, size_t{kMostThreads}));
  const Executor executor(std::clamp(std::min(cores, tasks), 1, kMostThreads));
  executor.For(order.size(), kMessagesATime, [&order](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) order[k].stream->ReadStamp(order[k].index);
  });
  for (const std::shared_ptr<MessageStream>& stream : streams) stream->FillStamps();
  return streams;
}

void MessageStream::ReadStamp(size_t index) {
  Entry& entry = entries_[index];
  try {
    const MessageBytes bytes = store_->ReadStart(entry.location, kStartBytes);
    WireReader reader(bytes.data, bytes.size, topic_.encoding, place_);
    entry.stamp = tvl::ReadStamp(&reader);
  } catch (const InputError&) {
    entry.stamp = {};  // reading the message will say what is wrong
  }
}

void MessageStream::FillStamps() {
  size_t without = 0;
  for (Entry& entry : entries_) {
    if (entry.stamp.ns != 0) continue;
    entry.stamp = entry.location.log_time;
    ++without;
  }
  SortByStamp();
  if (without == 0) return;
  warnings_.push_back(place_ + ": " + std::to_string(without) + " of " +
                      std::to_string(entries_.size()) +
                      " messages have no stamp in their header, or it cannot be read: the time of "
                      "recording is taken");
}

void MessageStream::SortByStamp() {
  std::stable_sort(entries_.begin(), entries_.end(),
                   [](const Entry& a, const Entry& b) { return a.stamp < b.stamp; });
}

void MessageStream::UseLogTimes() {
  for (Entry& entry : entries_) entry.stamp = entry.location.log_time;
  SortByStamp();
}

std::string MessageStream::Place(size_t index) const {
  return place_ + ": message " + std::to_string(index);
}

StoredMessage MessageStream::Read(size_t index) const {
  try {
    return {store_->Read(entries_.at(index).location), topic_.encoding, Place(index)};
  } catch (const InputError& error) {
    throw InputError(Place(index) + ": " + error.what());
  }
}

MessageStream::Span MessageStream::StampSpan() const {
  if (entries_.empty()) return {};
  return {entries_.front().stamp, entries_.back().stamp};
}

MessageStream::Span MessageStream::LogSpan() const {
  if (entries_.empty()) return {};
  Span span = {entries_.front().location.log_time, entries_.front().location.log_time};
  for (const Entry& entry : entries_) {
    span.first = std::min(span.first, entry.location.log_time);
    span.last = std::max(span.last, entry.location.log_time);
  }
  return span;
}

}  // namespace tvl
