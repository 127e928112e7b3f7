#include "tvl/io/cloud/file_streams.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/io/cloud/file_names.h"
#include "tvl/io/cloud/las.h"
#include "tvl/io/cloud/pcd.h"
#include "tvl/io/cloud/ply.h"

namespace tvl {
namespace {

namespace fs = std::filesystem;
using Kind = FrameFault::Kind;

constexpr size_t kTriedFiles = 3;  // until one can be read

bool IsFile(const std::string& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

bool IsEmptyFile(const std::string& path) {
  std::error_code error;
  return fs::file_size(path, error) == 0 && !error;
}

class FileScanStream : public ScanStream {
 public:
  FileScanStream(std::vector<std::string> paths, std::vector<Timestamp> stamps, ReadScanFile read)
      : paths_(std::move(paths)), stamps_(std::move(stamps)), read_(std::move(read)) {}

  size_t size() const override { return paths_.size(); }

  std::optional<Timestamp> Stamp(size_t index) const override {
    if (stamps_.empty()) return std::nullopt;
    return stamps_.at(index);
  }

  RawScanRead Read(size_t index) const override {
    const std::string& path = paths_.at(index);
    if (!IsFile(path)) return {nullptr, {{Kind::kMissingScan, path + ": no such file"}}};
    if (IsEmptyFile(path)) return {nullptr, {{Kind::kEmptyScan, path + ": no bytes"}}};
    try {
      CloudRead read = read_(path);
      if (read.scan.size() == 0) return {nullptr, {{Kind::kEmptyScan, path + ": no points"}}};
      return {std::make_shared<const RawScan>(std::move(read.scan)), {}};
    } catch (const InputError& error) {
      return {nullptr, {{Kind::kTruncatedScan, error.what()}}};
    }
  }

 private:
  std::vector<std::string> paths_;
  std::vector<Timestamp> stamps_;
  ReadScanFile read_;
};

class FileImageStream : public ImageStream {
 public:
  FileImageStream(std::vector<std::string> paths, std::vector<Timestamp> stamps, ImageSize size)
      : paths_(std::move(paths)), stamps_(std::move(stamps)), size_(size) {}

  size_t size() const override { return paths_.size(); }

  std::optional<Timestamp> Stamp(size_t index) const override {
    if (stamps_.empty()) return std::nullopt;
    return stamps_.at(index);
  }

  ImageRead Read(size_t index) const override {
    const std::string& path = paths_.at(index);
    if (!IsFile(path)) return {{}, {{Kind::kMissingImage, path + ": no such file"}}};
    return ReadImage(path, size_.width_px, size_.height_px);
  }

 private:
  std::vector<std::string> paths_;
  std::vector<Timestamp> stamps_;
  ImageSize size_;
};

std::string FieldText(const RawScan& scan) {
  std::string text = "x, y, z";
  const auto add = [&](const std::string& field, const std::string& meaning) {
    if (field.empty()) return;
    text += ", " + field + (field == meaning ? std::string() : " as " + meaning);
  };
  add(scan.intensity_field, "intensity");
  add(scan.ring_field, "ring");
  add(scan.time_field, "time");
  if (scan.height > 1) {
    text += "; " + std::to_string(scan.width) + " x " + std::to_string(scan.height) + " points";
  }
  return text;
}

}  // namespace

ReadScanFile ReaderOf(const std::string& path, const BinLayout& bin) {
  const std::string extension = ExtensionOf(path);
  if (extension == ".pcd") return ReadPcdScan;
  if (extension == ".ply") return ReadPlyScan;
  if (extension == ".las") return ReadLasScan;
  if (extension == ".bin") return [bin](const std::string& file) { return ReadBinScan(file, bin); };
  TVL_CHECK_INPUT(extension != ".laz")
      << path << ": compressed (LAZ), which is not read: unpack the files first, e.g. "
      << "`las2las -i in.laz -o out.las` or `pdal translate in.laz out.las`";
  throw InputError(path + ": not a scan: want .bin, .pcd, .ply or .las");
}

std::unique_ptr<ScanStream> MakeFileScanStream(std::vector<std::string> paths,
                                               std::vector<Timestamp> stamps, ReadScanFile read) {
  TVL_CHECK(stamps.empty() || stamps.size() == paths.size()) << stamps.size();
  return std::make_unique<FileScanStream>(std::move(paths), std::move(stamps), std::move(read));
}

std::unique_ptr<ImageStream> MakeFileImageStream(std::vector<std::string> paths,
                                                 std::vector<Timestamp> stamps, ImageSize size) {
  TVL_CHECK(stamps.empty() || stamps.size() == paths.size()) << stamps.size();
  return std::make_unique<FileImageStream>(std::move(paths), std::move(stamps), size);
}

ImageSize SizeOfFirstImage(const std::vector<std::string>& paths) {
  for (size_t i = 0; i < std::min(paths.size(), kTriedFiles); ++i) {
    const cv::Mat image = ReadImage(paths[i], 0, 0).image;
    if (!image.empty()) return {image.cols, image.rows};
  }
  return {};
}

std::vector<std::string> DescribeScans(const std::vector<std::string>& paths,
                                       const ReadScanFile& read) {
  std::string first_error;
  for (size_t i = 0; i < std::min(paths.size(), kTriedFiles); ++i) {
    try {
      const CloudRead cloud = read(paths[i]);
      std::vector<std::string> notes = {"scans: " + FieldText(cloud.scan)};
      for (const std::string& note : cloud.notes) notes.push_back(paths[i] + ": " + note);
      return notes;
    } catch (const InputError& error) {
      if (first_error.empty()) first_error = error.what();
    }
  }
  throw InputError(first_error);
}

}  // namespace tvl
