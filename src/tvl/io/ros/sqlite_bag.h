// ROS 2 bags in SQLite: rosbag2_storage_sqlite3 (github.com/ros2/rosbag2), tables "topics" and
// "messages".
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "tvl/io/ros/message_store.h"

struct sqlite3;
struct sqlite3_blob;

namespace tvl {

// True for files that begin as every SQLite database does.
bool IsSqliteFile(const std::string& path);

// Never writes. The index comes from one walk through the table that leaves the data alone.
class SqliteBag : public MessageStore {
 public:
  // Throws InputError for files that are no such database. One that is cut off is read as far as
  // its pages go, with a warning.
  explicit SqliteBag(const std::string& path);
  ~SqliteBag() override;

  const std::vector<MessageTopic>& topics() const override { return topics_; }
  MessageIndex Index(const std::vector<size_t>& topics) const override;
  MessageBytes Read(const MessageLocation& location) const override;
  MessageBytes ReadStart(const MessageLocation& location, size_t bytes) const override;
  std::string Describe() const override { return "ROS 2 SQLite database"; }
  const std::vector<std::string>& warnings() const override { return warnings_; }

 private:
  struct CloseDatabase {
    void operator()(sqlite3* database) const;
  };
  using Database = std::unique_ptr<sqlite3, CloseDatabase>;

  void Open(bool damaged);
  void ReadTopics();
  void CheckSize();
  MessageBytes ReadBlob(const MessageLocation& location, size_t most_bytes) const;

  std::string path_;
  std::vector<MessageTopic> topics_;
  std::vector<int64_t> ids_;                            // of the topics
  std::vector<std::vector<MessageLocation>> messages_;  // of the topics
  std::vector<std::string> warnings_;
  mutable std::mutex mutex_;  // one statement at a time
  Database database_;
};

}  // namespace tvl
