#include "tvl/io/ros/message_stream.h"

#include <algorithm>
#include <tuple>

#include "tvl/base/check.h"
#include "tvl/io/ros/topic_list.h"

namespace tvl {
namespace {

// The stamp, and in CDR the encapsulation header before it.
constexpr size_t kStartBytes = kStampBytes + 4;

}  // namespace

MessageStream::MessageStream(std::shared_ptr<const MessageStore> store, MessageTopic topic,
                             const std::vector<MessageLocation>& messages, const std::string& file)
    : store_(std::move(store)), topic_(std::move(topic)), place_(file + ": " + topic_.name) {
  entries_.reserve(messages.size());
  for (const MessageLocation& location : messages) entries_.push_back({location, {}});
  ReadStamps();
  SortByStamp();
}

void MessageStream::ReadStamps() {
  // The last message of a chunk first: the chunk is then inflated once, as far as is needed.
  std::vector<size_t> order(entries_.size());
  for (size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::sort(order.begin(), order.end(), [this](size_t a, size_t b) {
    const MessageLocation &la = entries_[a].location, &lb = entries_[b].location;
    return std::tie(la.part, la.block, lb.offset, a) < std::tie(lb.part, lb.block, la.offset, b);
  });
  RepeatedWarning unreadable;
  size_t without = 0;
  for (const size_t k : order) {
    Entry& entry = entries_[k];
    try {
      const MessageBytes bytes = store_->ReadStart(entry.location, kStartBytes);
      WireReader reader(bytes.data, bytes.size, topic_.encoding, place_);
      entry.stamp = ReadStamp(&reader);
      without += entry.stamp.ns == 0;
    } catch (const InputError& error) {
      unreadable.Add(std::string(error.what()) + "; the message's log time is taken");
    }
    if (entry.stamp.ns == 0) entry.stamp = entry.location.log_time;
  }
  unreadable.MoveTo(&warnings_);
  if (without == 0) return;
  warnings_.push_back(place_ + ": " + std::to_string(without) + " of " +
                      std::to_string(entries_.size()) +
                      " messages have no stamp in their header: the time of recording is taken");
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
