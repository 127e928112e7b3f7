// The descriptors of many images: what vocabularies are trained on and compared with.
#pragma once

#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "tvl/base/parallel.h"
#include "tvl/frame/image_features.h"

namespace tvl {

// Images wherever they come from, read or made when asked for. Thread-safe.
using ImageSource = std::function<cv::Mat()>;

// Each of `specs` is an image file, a folder of image files (png, jpg; by name), or an INPUT with a
// camera (a folder in a KITTI layout, or sim:PRESET?key=value&...). Of each, every stride-th image
// from the first on. Throws InputError for what is none of these, naming it.
std::vector<ImageSource> FindImages(const std::vector<std::string>& specs, size_t stride);

// One list an image, in order; `progress` is called with the number of images done. Images that
// cannot be used have no descriptors.
std::vector<std::vector<BinaryDescriptor>> DescribeImages(
    const std::vector<ImageSource>& images, const Executor& executor,
    const std::function<void(size_t)>& progress);

}  // namespace tvl
