#include "tvl/cli/image_descriptors.h"

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "tvl/base/check.h"
#include "tvl/cli/input.h"
#include "tvl/vision/image_feature_extractor.h"

namespace tvl {
namespace {

namespace fs = std::filesystem;

bool IsImageFile(const fs::path& path) {
  const std::string extension = path.extension().string();
  return extension == ".png" || extension == ".jpg" || extension == ".jpeg";
}

// By name. Empty for anything but image files and folders with image files in them.
std::vector<std::string> ImageFilesOf(const std::string& spec) {
  if (fs::is_regular_file(spec) && IsImageFile(spec)) return {spec};
  std::vector<std::string> files;
  if (!fs::is_directory(spec)) return files;
  for (const fs::directory_entry& entry : fs::directory_iterator(spec)) {
    if (entry.is_regular_file() && IsImageFile(entry.path())) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

cv::Mat ReadImageFile(const std::string& path) {
  const cv::Mat image = cv::imread(path, cv::IMREAD_ANYDEPTH | cv::IMREAD_COLOR);
  TVL_CHECK_INPUT(!image.empty()) << path << ": cannot be read as an image";
  return image;
}

std::vector<ImageSource> ImagesOf(const std::string& spec) {
  std::vector<ImageSource> images;
  for (const std::string& file : ImageFilesOf(spec)) {
    images.emplace_back([file] { return ReadImageFile(file); });
  }
  if (!images.empty()) return images;
  InputOptions options;
  options.require_first_scan = false;
  const std::shared_ptr<const Dataset> dataset = OpenInput(spec, options);
  TVL_CHECK_INPUT(dataset->setup().has_camera) << spec << ": has no images";
  for (size_t i = 0; i < dataset->size(); ++i) {
    images.emplace_back([dataset, i] { return dataset->Frame(i).image; });
  }
  return images;
}

// Descriptors do not depend on the camera.
Camera AnyCamera() {
  Camera camera;
  camera.fx_px = camera.fy_px = 1.0;
  return camera;
}

}  // namespace

std::vector<ImageSource> FindImages(const std::vector<std::string>& specs, size_t stride) {
  TVL_CHECK_INPUT(stride >= 1) << "--stride: must be at least 1";
  std::vector<ImageSource> chosen;
  for (const std::string& spec : specs) {
    const std::vector<ImageSource> images = ImagesOf(spec);
    for (size_t i = 0; i < images.size(); i += stride) chosen.push_back(images[i]);
  }
  return chosen;
}

std::vector<std::vector<BinaryDescriptor>> DescribeImages(
    const std::vector<ImageSource>& images, const Executor& executor,
    const std::function<void(size_t)>& progress) {
  const ImageFeatureExtractor extractor;
  std::vector<std::vector<BinaryDescriptor>> descriptors(images.size());
  constexpr size_t kBatch = 8;  // between two reports
  for (size_t begin = 0; begin < images.size(); begin += kBatch) {
    const size_t count = std::min(kBatch, images.size() - begin);
    executor.For(count, 1, [&](size_t first, size_t last) {
      for (size_t i = begin + first; i < begin + last; ++i) {
        descriptors[i] = extractor.Extract(images[i](), AnyCamera()).descriptors;
      }
    });
    progress(begin + count);
  }
  return descriptors;
}

}  // namespace tvl
