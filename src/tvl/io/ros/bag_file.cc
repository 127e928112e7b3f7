#include "tvl/io/ros/bag_file.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "tvl/base/check.h"
#include "tvl/io/ros/mcap.h"
#include "tvl/io/ros/ros1_bag.h"
#include "tvl/io/ros/split_store.h"
#include "tvl/io/ros/sqlite_bag.h"

namespace tvl {
namespace {

namespace fs = std::filesystem;

constexpr char kMetadata[] = "metadata.yaml";
// Metadata list the topics with their quality of service: kilobytes.
constexpr uint64_t kMostMetadataBytes = uint64_t{1} << 24;

bool HasBagExtension(const fs::path& path) {
  const std::string extension = path.extension().string();
  return extension == ".bag" || extension == ".db3" || extension == ".mcap";
}

// Ordered by name, as recorders number them.
std::vector<std::string> BagFilesIn(const std::string& folder) {
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (HasBagExtension(entry.path()) && entry.is_regular_file()) {
      files.push_back(entry.path().string());
    }
  }
  // "bag_10" comes after "bag_9".
  std::sort(files.begin(), files.end(), [](const std::string& a, const std::string& b) {
    return a.size() != b.size() ? a.size() < b.size() : a < b;
  });
  return files;
}

YAML::Node ReadMetadata(const std::string& file) {
  TVL_CHECK_INPUT(fs::file_size(file) <= kMostMetadataBytes) << file << ": too large";
  try {
    const YAML::Node root = YAML::LoadFile(file);
    const YAML::Node information =
        root.IsMap() ? root["rosbag2_bagfile_information"] : YAML::Node();
    TVL_CHECK_INPUT(information.IsMap()) << file << ": no rosbag2_bagfile_information";
    const auto mode = information["compression_mode"].as<std::string>("");
    TVL_CHECK_INPUT(mode.empty() || mode == "none" || mode == "NONE")
        << file << ": the bag is compressed by " << mode << "; unpack it first with 'ros2 bag "
        << "convert' (compression within .mcap files is read as it is)";
    return information;
  } catch (const YAML::Exception& error) {
    throw InputError(file + ": " + error.what());
  }
}

// Throws InputError for names that lead out of the folder.
std::string PathInside(const std::string& folder, const std::string& name) {
  const fs::path relative(name);
  const bool leaves =
      relative.is_absolute() || std::any_of(relative.begin(), relative.end(),
                                            [](const fs::path& part) { return part == ".."; });
  TVL_CHECK_INPUT(!leaves && !name.empty())
      << folder << "/" << kMetadata << ": file name '" << name << "' leaves the folder";
  const fs::path path = fs::path(folder) / relative;
  // The first versions wrote the folder's own name before the file's.
  return fs::exists(path) ? path.string() : (fs::path(folder) / relative.filename()).string();
}

std::vector<std::string> FilesOfMetadata(const std::string& folder) {
  const std::string file = (fs::path(folder) / kMetadata).string();
  const YAML::Node names = ReadMetadata(file)["relative_file_paths"];
  TVL_CHECK_INPUT(names.IsDefined() && names.IsSequence() && names.size() > 0)
      << file << ": no relative_file_paths";
  std::vector<std::string> files;
  for (const YAML::Node& name : names) {
    files.push_back(PathInside(folder, name.as<std::string>("")));
  }
  return files;
}

std::unique_ptr<MessageStore> OpenOne(const std::string& path) {
  if (IsSqliteFile(path)) return std::make_unique<SqliteBag>(path);
  const std::shared_ptr<const ByteSource> source = OpenFileSource(path);
  if (IsMcap(*source)) return std::make_unique<Mcap>(source);
  if (IsRos1Bag(*source)) return std::make_unique<Ros1Bag>(source);
  throw InputError(path + ": neither a ROS 1 bag, nor an SQLite database, nor an MCAP file");
}

// Warnings of a split bag's missing files, as a part without topics.
class MissingParts : public MessageStore {
 public:
  explicit MissingParts(std::vector<std::string> warnings) : warnings_(std::move(warnings)) {}
  const std::vector<MessageTopic>& topics() const override { return topics_; }
  MessageIndex Index(const std::vector<size_t>& topics) const override {
    MessageIndex index;
    index.topics.resize(topics.size());
    return index;
  }
  MessageBytes Read(const MessageLocation& /*location*/) const override {
    throw InputError("a message of a missing file");
  }
  MessageBytes ReadStart(const MessageLocation& location, size_t /*bytes*/) const override {
    return Read(location);
  }
  std::string Describe() const override { return "missing"; }
  const std::vector<std::string>& warnings() const override { return warnings_; }

 private:
  std::vector<MessageTopic> topics_;
  std::vector<std::string> warnings_;
};

std::unique_ptr<MessageStore> OpenFolder(const std::string& folder) {
  const bool has_metadata = fs::exists(fs::path(folder) / kMetadata);
  const std::vector<std::string> files =
      has_metadata ? FilesOfMetadata(folder) : BagFilesIn(folder);
  TVL_CHECK_INPUT(!files.empty()) << folder << ": no bag files";
  std::vector<std::unique_ptr<MessageStore>> parts;
  std::vector<std::string> missing;
  for (const std::string& file : files) {
    try {
      parts.push_back(OpenOne(file));
    } catch (const InputError& error) {
      if (files.size() == 1) throw;
      missing.push_back(std::string(error.what()) + "; the other files of the bag are used");
    }
  }
  TVL_CHECK_INPUT(!parts.empty()) << missing.front() << ": there are none";
  if (!missing.empty()) parts.push_back(std::make_unique<MissingParts>(missing));
  return parts.size() == 1 ? std::move(parts.front())
                           : std::make_unique<SplitStore>(std::move(parts));
}

}  // namespace

bool LooksLikeBag(const std::string& path) {
  try {
    if (fs::is_directory(path)) {
      const fs::path metadata = fs::path(path) / kMetadata;
      if (!fs::exists(metadata)) return !BagFilesIn(path).empty();
      ReadMetadata(metadata.string());
      return true;
    }
    if (!fs::is_regular_file(path)) return false;
    const std::unique_ptr<ByteSource> source = OpenFileSource(path);
    return IsSqliteFile(path) || IsMcap(*source) || IsRos1Bag(*source);
  } catch (const std::exception&) {
    return false;
  }
}

std::unique_ptr<MessageStore> OpenBagFile(const std::string& path) {
  return fs::is_directory(path) ? OpenFolder(path) : OpenOne(path);
}

}  // namespace tvl
