#include "tvl/map/keyframe_store.h"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <list>
#include <map>
#include <mutex>
#include <vector>

#include "tvl/base/check.h"

namespace tvl {
namespace {

template <typename T>
size_t BytesOf(const std::vector<T>& values) {
  return values.size() * sizeof(T);
}

// A payload as bytes: each array as its length and its elements.
class Writer {
 public:
  template <typename T>
  void Add(const std::vector<T>& values) {
    const uint64_t n = values.size();
    Append(&n, sizeof n);
    Append(values.data(), BytesOf(values));
  }
  const std::vector<char>& bytes() const { return bytes_; }

 private:
  void Append(const void* data, size_t n) {
    const char* begin = static_cast<const char*>(data);
    bytes_.insert(bytes_.end(), begin, begin + n);
  }
  std::vector<char> bytes_;
};

class Reader {
 public:
  explicit Reader(const std::vector<char>& bytes) : bytes_(bytes) {}
  template <typename T>
  void Take(std::vector<T>* values) {
    uint64_t n = 0;
    Copy(&n, sizeof n);
    values->resize(n);
    Copy(values->data(), n * sizeof(T));
  }

 private:
  void Copy(void* to, size_t n) {
    TVL_CHECK(at_ + n <= bytes_.size()) << "keyframe store: a payload is cut short";
    if (n > 0) std::memcpy(to, bytes_.data() + at_, n);
    at_ += n;
  }
  const std::vector<char>& bytes_;
  size_t at_ = 0;
};

// Calls visit(array) for each array of a payload, in the order of the file.
template <typename Payload, typename Visit>
void ForEachArray(Payload& payload, const Visit& visit) {
  visit(payload.cloud.edges.points);
  visit(payload.cloud.edges.intensity);
  visit(payload.cloud.planes.points);
  visit(payload.cloud.planes.intensity);
  visit(payload.image.px_cam);
  visit(payload.image.ray_cam);
  visit(payload.image.depth_m);
  visit(payload.image.descriptors);
}

// A file without a name: the system takes it back however the program ends.
class SpillFile {
 public:
  explicit SpillFile(std::string folder) : folder_(std::move(folder)) {}
  ~SpillFile() {
    if (file_ >= 0) close(file_);
  }
  SpillFile(const SpillFile&) = delete;
  SpillFile& operator=(const SpillFile&) = delete;

  // Returns where the bytes begin.
  size_t Append(const std::vector<char>& bytes) {
    if (file_ < 0) Open();
    size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t n =
          pwrite(file_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(size_ + done));
      if (n < 0 && errno == EINTR) continue;
      TVL_CHECK_INPUT(n > 0) << folder_
                             << ": keyframes cannot be written: " << std::strerror(errno);
      done += static_cast<size_t>(n);
    }
    const size_t begin = size_;
    size_ += bytes.size();
    return begin;
  }
  std::vector<char> Read(size_t begin, size_t n) const {
    std::vector<char> bytes(n);
    size_t done = 0;
    while (done < n) {
      const ssize_t got =
          pread(file_, bytes.data() + done, n - done, static_cast<off_t>(begin + done));
      if (got < 0 && errno == EINTR) continue;
      TVL_CHECK_INPUT(got > 0) << folder_ << ": keyframes cannot be read back";
      done += static_cast<size_t>(got);
    }
    return bytes;
  }
  size_t size() const { return size_; }

 private:
  void Open() {
    std::error_code error;
    if (folder_.empty()) folder_ = std::filesystem::temp_directory_path(error).string();
    TVL_CHECK_INPUT(!error) << "no folder for temporary files: " << error.message();
    std::string name = folder_ + "/tvl_keyframes_XXXXXX";
    file_ = mkstemp(name.data());
    TVL_CHECK_INPUT(file_ >= 0) << folder_
                                << ": no file for keyframes can be made: " << std::strerror(errno);
    unlink(name.c_str());
  }
  std::string folder_;
  int file_ = -1;
  size_t size_ = 0;
};

}  // namespace

void KeyframeStoreOptions::Check() const {
  TVL_CHECK_INPUT(memory_mib >= 0.0) << "keyframe_store.memory_mib: must not be negative";
}

size_t SizeOf(const KeyframePayload& payload) {
  size_t bytes = 0;
  ForEachArray(payload, [&](const auto& values) { bytes += BytesOf(values); });
  return bytes;
}

struct KeyframeStore::Impl {
  struct Entry {
    std::shared_ptr<const KeyframePayload> payload;  // null: in the file only
    size_t bytes = 0;                                // in memory
    size_t file_begin = 0, file_bytes = 0;           // file_bytes 0: not in the file
    std::list<int>::iterator use;                    // in `order`; its end: not there
  };

  explicit Impl(const KeyframeStoreOptions& options)
      : budget(static_cast<size_t>(options.memory_mib * 1024.0 * 1024.0)), file(options.folder) {}

  void Hold(int index, Entry* entry) {
    order.push_back(index);
    entry->use = std::prev(order.end());
    entry->bytes = SizeOf(*entry->payload);
    memory += entry->bytes;
  }
  void LetGo(Entry* entry) {
    Unlist(entry);
    memory -= entry->bytes;
    entry->payload = nullptr;
  }
  // It leaves memory, or stays in it for good.
  void Unlist(Entry* entry) {
    if (entry->use != order.end()) order.erase(entry->use);
    entry->use = order.end();
  }
  // Least recently used first; the newest stays whatever its size, and what cannot be written.
  void Trim() {
    while (memory > budget && order.size() > 1) {
      Entry& entry = entries.at(order.front());
      if (entry.file_bytes == 0) Save(&entry);
      if (entry.file_bytes > 0) {
        LetGo(&entry);
      } else {
        Unlist(&entry);
      }
    }
  }
  // Does nothing once there was a fault.
  void Save(Entry* entry) {
    if (!fault.empty()) return;
    Writer writer;
    ForEachArray(*entry->payload, [&](const auto& values) { writer.Add(values); });
    try {
      entry->file_begin = file.Append(writer.bytes());
      entry->file_bytes = writer.bytes().size();
    } catch (const InputError& error) {
      fault = error.what();
    }
  }
  std::shared_ptr<const KeyframePayload> Load(const Entry& entry) const {
    const std::vector<char> bytes = file.Read(entry.file_begin, entry.file_bytes);
    auto payload = std::make_shared<KeyframePayload>();
    Reader reader(bytes);
    ForEachArray(*payload, [&](auto& values) { reader.Take(&values); });
    return payload;
  }

  size_t budget, memory = 0;
  std::map<int, Entry> entries;
  std::list<int> order;  // in memory and free to leave it, least recently used first
  SpillFile file;
  std::string fault;
  std::mutex mutex;
};

KeyframeStore::KeyframeStore(const KeyframeStoreOptions& options)
    : impl_((options.Check(), std::make_unique<Impl>(options))) {}
KeyframeStore::~KeyframeStore() = default;

void KeyframeStore::Put(int index, std::shared_ptr<const KeyframePayload> payload) {
  TVL_CHECK(payload != nullptr) << "keyframe store: no payload";
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  Impl::Entry& entry = impl_->entries[index];
  if (entry.payload != nullptr) impl_->LetGo(&entry);
  entry = {std::move(payload), 0, 0, 0, impl_->order.end()};
  impl_->Hold(index, &entry);
  impl_->Trim();
}

std::shared_ptr<const KeyframePayload> KeyframeStore::Get(int index) const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  const auto found = impl_->entries.find(index);
  TVL_CHECK(found != impl_->entries.end()) << "keyframe store: no keyframe " << index;
  Impl::Entry& entry = found->second;
  if (entry.payload == nullptr) {
    entry.payload = impl_->Load(entry);
    impl_->Hold(index, &entry);
  } else if (entry.use != impl_->order.end()) {
    impl_->order.splice(impl_->order.end(), impl_->order, entry.use);
  }
  std::shared_ptr<const KeyframePayload> payload = entry.payload;
  impl_->Trim();
  return payload;
}

std::shared_ptr<const KeyframeCloud> KeyframeStore::Cloud(int index) const {
  const std::shared_ptr<const KeyframePayload> payload = Get(index);
  return {payload, &payload->cloud};
}

std::shared_ptr<const ImageFeatures> KeyframeStore::Image(int index) const {
  const std::shared_ptr<const KeyframePayload> payload = Get(index);
  return {payload, &payload->image};
}

size_t KeyframeStore::memory_bytes() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return impl_->memory;
}

size_t KeyframeStore::file_bytes() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return impl_->file.size();
}

std::string KeyframeStore::fault() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return impl_->fault;
}

}  // namespace tvl
