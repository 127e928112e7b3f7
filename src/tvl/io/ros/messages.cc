#include "tvl/io/ros/messages.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// A sensor has at most a few thousand pixels a side; larger numbers are damage.
constexpr uint32_t kMostPixelsASide = 1U << 16;
// Quaternions are normalised up to printing and single precision.
constexpr double kNormTolerance = 0.01;
// A header (16 bytes at least), two names and seven numbers.
constexpr size_t kLeastTransformBytes = 16 + 4 + 7 * 8;

template <size_t N>
std::array<double, N> ReadArray(WireReader* reader) {
  std::array<double, N> values;
  for (double& value : values) value = reader->Number<double>();
  return values;
}

std::string FrameName(std::string name) {
  if (!name.empty() && name.front() == '/') name.erase(0, 1);  // as the first tf wrote them
  return name;
}

bool AllFinite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

// Coefficients in the order of OpenCV, and of the model.
void SetDistortion(const CameraInfoMessage& info, const std::string& source, Camera* camera) {
  const std::string& name = info.distortion_model;
  const auto zero = [](double v) { return v == 0.0; };
  if (std::all_of(info.D.begin(), info.D.end(), zero) && name != "equidistant" &&
      name != "fisheye") {
    return;
  }
  size_t used = 0;
  if (name == "plumb_bob" || name == "radtan" || name.empty()) {
    used = 5;
  } else if (name == "rational_polynomial") {
    camera->distortion_model = DistortionModel::kRational;
    used = 8;
  } else if (name == "equidistant" || name == "fisheye" || name == "kannala_brandt4") {
    camera->distortion_model = DistortionModel::kEquidistant;
    used = 4;
  }
  TVL_CHECK_INPUT(used > 0) << source << ": distortion model '" << name.substr(0, 64)
                            << "' is not known (plumb_bob, rational_polynomial, equidistant are)";
  // Beyond the model's own there may be coefficients of a thin prism and a tilt, mostly zero.
  TVL_CHECK_INPUT(
      info.D.size() <= used ||
      std::all_of(info.D.begin() + static_cast<std::ptrdiff_t>(used), info.D.end(), zero))
      << source << ": " << info.D.size() << " coefficients of '" << name << "', of which " << used
      << " are understood";
  std::copy_n(info.D.begin(), std::min(used, info.D.size()), camera->distortion.begin());
}

// Images may be a part of what the sensor sees, at a lower resolution.
void Crop(const CameraInfoMessage& info, Camera* camera) {
  const double bx = std::max(1U, info.binning_x), by = std::max(1U, info.binning_y);
  camera->fx_px /= bx, camera->fy_px /= by;
  camera->cx_px = (camera->cx_px - info.roi_x) / bx;
  camera->cy_px = (camera->cy_px - info.roi_y) / by;
  const bool whole = info.roi_width == 0 || info.roi_height == 0;
  camera->width_px = static_cast<int>((whole ? info.width_px : info.roi_width) / bx);
  camera->height_px = static_cast<int>((whole ? info.height_px : info.roi_height) / by);
}

}  // namespace

MessageKind KindOfType(const std::string& type) {
  const size_t first = type.find('/'), last = type.rfind('/');
  if (first == std::string::npos) return MessageKind::kOther;
  const std::string package = type.substr(0, first), name = type.substr(last + 1);
  if (package == "sensor_msgs") {
    if (name == "PointCloud2") return MessageKind::kPointCloud2;
    if (name == "Image") return MessageKind::kImage;
    if (name == "CompressedImage") return MessageKind::kCompressedImage;
    if (name == "CameraInfo") return MessageKind::kCameraInfo;
  }
  if (package.rfind("livox", 0) == 0 && name == "CustomMsg") return MessageKind::kLivoxPoints;
  if (name == "TFMessage" || name == "tfMessage") return MessageKind::kTransforms;
  const bool packets = name == "VelodyneScan" || name == "PacketMsg" || name == "NovatelPacket" ||
                       name == "HesaiScan" || name == "PandarScan" || name == "RslidarScan";
  return packets ? MessageKind::kLidarPackets : MessageKind::kOther;
}

Timestamp ReadStamp(WireReader* reader) {
  if (reader->encoding() == MessageEncoding::kRos1) reader->Number<uint32_t>();  // sequence number
  const auto seconds = reader->Number<uint32_t>();
  const auto nanoseconds = reader->Number<uint32_t>();
  // ROS 2 has signed seconds, ROS 1 unsigned ones.
  const bool is_signed = reader->encoding() == MessageEncoding::kCdr;
  const int64_t whole = is_signed ? static_cast<int32_t>(seconds) : int64_t{seconds};
  return {whole * 1'000'000'000 + int64_t{nanoseconds}};
}

MessageHeader ReadHeader(WireReader* reader) {
  const Timestamp stamp = ReadStamp(reader);
  return {stamp, FrameName(reader->String())};
}

CameraInfoMessage DecodeCameraInfo(const StoredMessage& message) {
  WireReader reader = message.Reader();
  CameraInfoMessage info;
  info.header = ReadHeader(&reader);
  info.height_px = reader.Number<uint32_t>();
  info.width_px = reader.Number<uint32_t>();
  info.distortion_model = reader.String();
  info.D.resize(reader.Count(sizeof(double)));
  for (double& d : info.D) d = reader.Number<double>();
  info.K = ReadArray<9>(&reader);
  info.R = ReadArray<9>(&reader);
  info.P = ReadArray<12>(&reader);
  info.binning_x = reader.Number<uint32_t>();
  info.binning_y = reader.Number<uint32_t>();
  info.roi_x = reader.Number<uint32_t>();
  info.roi_y = reader.Number<uint32_t>();
  info.roi_height = reader.Number<uint32_t>();
  info.roi_width = reader.Number<uint32_t>();
  return info;
}

Camera CameraOf(const CameraInfoMessage& info, bool rectified, const std::string& source) {
  Camera camera;
  camera.fx_px = rectified ? info.P[0] : info.K[0];
  camera.fy_px = rectified ? info.P[5] : info.K[4];
  camera.cx_px = rectified ? info.P[2] : info.K[2];
  camera.cy_px = rectified ? info.P[6] : info.K[5];
  TVL_CHECK_INPUT(AllFinite({camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px}) &&
                  AllFinite(info.D))
      << source << ": numbers that are not finite";
  TVL_CHECK_INPUT(camera.fx_px > 0.0 && camera.fy_px > 0.0)
      << source << ": focal length " << camera.fx_px << ", " << camera.fy_px
      << ": the camera was not calibrated";
  TVL_CHECK_INPUT(std::max({info.width_px, info.height_px, info.roi_width, info.roi_height,
                            info.roi_x, info.roi_y}) <= kMostPixelsASide)
      << source << ": an image of " << info.width_px << " x " << info.height_px << " pixels";
  if (!rectified) SetDistortion(info, source, &camera);
  Crop(info, &camera);
  return camera;
}

std::vector<FrameTransform> DecodeTransforms(const StoredMessage& message) {
  WireReader reader = message.Reader();
  std::vector<FrameTransform> transforms(reader.Count(kLeastTransformBytes));
  for (FrameTransform& transform : transforms) {
    transform.parent = ReadHeader(&reader).frame_id;
    transform.child = FrameName(reader.String());
    const std::array<double, 7> v = ReadArray<7>(&reader);  // translation, then x, y, z, w
    const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
    const bool finite = std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); });
    TVL_CHECK_INPUT(finite && std::abs(q.norm() - 1.0) < kNormTolerance)
        << message.place << ": the transform from '" << transform.parent << "' to '"
        << transform.child << "' is no rigid motion";
    transform.T_parent_child = Rigid3d(q, Eigen::Vector3d(v[0], v[1], v[2]));
  }
  return transforms;
}

}  // namespace tvl
