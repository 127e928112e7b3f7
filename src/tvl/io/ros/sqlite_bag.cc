#include "tvl/io/ros/sqlite_bag.h"

#include <sqlite3.h>

#include <algorithm>
#include <cstring>
#include <fstream>

#include "tvl/base/check.h"
#include "tvl/io/ros/byte_source.h"
#include "tvl/io/ros/topic_list.h"

namespace tvl {
namespace {

// The first 16 bytes of every SQLite database (sqlite.org/fileformat.html).
constexpr char kMagic[16] = "SQLite format 3";

struct FinishStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Statement = std::unique_ptr<sqlite3_stmt, FinishStatement>;

struct CloseBlob {
  void operator()(sqlite3_blob* blob) const { sqlite3_blob_close(blob); }
};
using Blob = std::unique_ptr<sqlite3_blob, CloseBlob>;

Statement Prepare(sqlite3* database, const char* sql, const std::string& path) {
  sqlite3_stmt* statement = nullptr;
  const int status = sqlite3_prepare_v2(database, sql, -1, &statement, nullptr);
  TVL_CHECK_INPUT(status == SQLITE_OK)
      << path << ": not a ROS 2 bag that can be read: " << sqlite3_errmsg(database);
  return Statement(statement);
}

std::string Text(sqlite3_stmt* statement, int column) {
  const unsigned char* text = sqlite3_column_text(statement, column);
  return text == nullptr ? "" : reinterpret_cast<const char*>(text);
}

// As a part of a URI, in which some characters mean something.
std::string UriOf(const std::string& path) {
  static constexpr char kDigits[] = "0123456789ABCDEF";
  std::string uri = "file:";
  for (const char c : path) {
    if (c != '%' && c != '?' && c != '#') {
      uri += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    uri += {'%', kDigits[byte >> 4U], kDigits[byte & 15U]};
  }
  return uri;
}

}  // namespace

bool IsSqliteFile(const std::string& path) {
  char start[sizeof(kMagic)] = {};
  std::ifstream file(path, std::ios::binary);
  return file.read(start, sizeof(start)) && std::memcmp(start, kMagic, sizeof(kMagic)) == 0;
}

void SqliteBag::CloseDatabase::operator()(sqlite3* database) const { sqlite3_close(database); }

SqliteBag::SqliteBag(const std::string& path) : path_(path) {
  TVL_CHECK_INPUT(IsSqliteFile(path)) << path << ": not an SQLite database";
  try {
    Open(false);
    ReadTopics();
    CheckSize();
  } catch (const InputError&) {
    // Cut off, or with a journal that cannot be used in a folder that cannot be written.
    topics_.clear(), ids_.clear();
    Open(true);
    ReadTopics();
    warnings_.push_back(path +
                        ": the database is damaged, cut off or was not closed; what can be "
                        "read of it is used ('sqlite3 FILE .recover' may mend it)");
  }
}

SqliteBag::~SqliteBag() = default;

void SqliteBag::Open(bool damaged) {
  // "immutable" disregards journals; the schema made writable, which needs no writing, makes SQLite
  // go on where the file is shorter than its header says.
  const std::string uri = UriOf(path_) + (damaged ? "?mode=ro&immutable=1" : "?mode=ro");
  sqlite3* database = nullptr;
  const int flags = SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX;
  const int status = sqlite3_open_v2(uri.c_str(), &database, flags, nullptr);
  database_.reset(database);
  TVL_CHECK_INPUT(status == SQLITE_OK) << path_ << ": cannot be opened as an SQLite database";
  // Views and triggers of the file may not do more than read.
  sqlite3_db_config(database, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  if (damaged) sqlite3_db_config(database, SQLITE_DBCONFIG_WRITABLE_SCHEMA, 1, nullptr);
  sqlite3_limit(database, SQLITE_LIMIT_LENGTH, static_cast<int>(kMostMessageBytes));
}

void SqliteBag::ReadTopics() {
  const Statement statement = Prepare(database_.get(),
                                      "SELECT id, name, type, serialization_format FROM topics "
                                      "ORDER BY name, type, id",
                                      path_);
  while (sqlite3_step(statement.get()) == SQLITE_ROW) {
    ids_.push_back(sqlite3_column_int64(statement.get(), 0));
    const bool cdr = Text(statement.get(), 3) == "cdr";
    topics_.push_back({Text(statement.get(), 1), Text(statement.get(), 2),
                       cdr ? MessageEncoding::kCdr : MessageEncoding::kOther, 0});
  }
  const Statement messages =
      Prepare(database_.get(), "SELECT id, topic_id, timestamp FROM messages ORDER BY id", path_);
  messages_.assign(topics_.size(), {});
  int status = SQLITE_ROW;
  while ((status = sqlite3_step(messages.get())) == SQLITE_ROW) {
    const auto topic = std::find(ids_.begin(), ids_.end(), sqlite3_column_int64(messages.get(), 1));
    if (topic == ids_.end()) continue;
    const auto offset = static_cast<uint64_t>(sqlite3_column_int64(messages.get(), 0));
    messages_[static_cast<size_t>(topic - ids_.begin())].push_back(
        {{sqlite3_column_int64(messages.get(), 2)}, offset, 0, 0});
  }
  for (size_t k = 0; k < topics_.size(); ++k) topics_[k].count = messages_[k].size();
  if (status == SQLITE_DONE) return;
  size_t count = 0;
  for (const std::vector<MessageLocation>& topic : messages_) count += topic.size();
  warnings_.push_back(path_ + ": the table of messages ends early after " + std::to_string(count) +
                      " messages: " + sqlite3_errmsg(database_.get()));
}

// The header tells the number of pages, which SQLite itself does not always compare.
void SqliteBag::CheckSize() {
  const std::unique_ptr<ByteSource> source = OpenFileSource(path_);
  const std::vector<uint8_t> header = source->Read(0, uint64_t{32});
  const auto big_endian = [&header](size_t begin, size_t count) {
    uint64_t value = 0;
    for (size_t k = begin; k < begin + count; ++k) value = value << 8U | header[k];
    return value;
  };
  const uint64_t page_bytes = big_endian(16, 2);  // 1 stands for 65536
  const uint64_t pages = big_endian(28, 4);
  const uint64_t bytes = pages * (page_bytes == 1 ? 65536 : page_bytes);
  if (bytes <= source->size()) return;
  warnings_.push_back(path_ + ": byte " + std::to_string(source->size()) + ": cut off, " +
                      std::to_string(bytes) + " bytes by its header");
}

MessageIndex SqliteBag::Index(const std::vector<size_t>& topics) const {
  MessageIndex index;
  for (const size_t topic : topics) {
    index.topics.push_back(messages_.at(topic));
    SortByLogTime(&index.topics.back());
  }
  return index;
}

MessageBytes SqliteBag::ReadBlob(const MessageLocation& location, size_t most_bytes) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::string place = path_ + ": message " + std::to_string(location.offset);
  sqlite3_blob* opened = nullptr;
  const int status = sqlite3_blob_open(database_.get(), "main", "messages", "data",
                                       static_cast<sqlite3_int64>(location.offset), 0, &opened);
  const Blob blob(opened);
  TVL_CHECK_INPUT(status == SQLITE_OK) << place << ": " << sqlite3_errmsg(database_.get());
  const auto size = static_cast<size_t>(std::max(0, sqlite3_blob_bytes(opened)));
  TVL_CHECK_INPUT(size <= kMostMessageBytes) << place << ": too large: " << size << " bytes";
  auto bytes = std::make_shared<std::vector<uint8_t>>(std::min(size, most_bytes));
  TVL_CHECK_INPUT(sqlite3_blob_read(opened, bytes->data(), static_cast<int>(bytes->size()), 0) ==
                  SQLITE_OK)
      << place << ": " << sqlite3_errmsg(database_.get());
  return {bytes, bytes->data(), bytes->size()};
}

MessageBytes SqliteBag::Read(const MessageLocation& location) const {
  return ReadBlob(location, kMostMessageBytes);
}

MessageBytes SqliteBag::ReadStart(const MessageLocation& location, size_t bytes) const {
  return ReadBlob(location, bytes);
}

}  // namespace tvl
