#include "tvl/io/rig.h"

#include <algorithm>
#include <array>
#include <iomanip>
#include <sstream>
#include <vector>

#include "tvl/base/units.h"
#include "tvl/io/kitti_calibration.h"
#include "tvl/io/yaml_values.h"

namespace tvl {
namespace {

struct DistortionName {
  const char* name;
  DistortionModel model;
  size_t coefficients;
};
constexpr std::array<DistortionName, 3> kDistortions = {
    {{"plumb_bob", DistortionModel::kRadialTangential, 5},
     {"rational", DistortionModel::kRational, 8},
     {"equidistant", DistortionModel::kEquidistant, 4}}};

const DistortionName& NameOf(DistortionModel model) {
  return *std::find_if(kDistortions.begin(), kDistortions.end(),
                       [&](const DistortionName& d) { return d.model == model; });
}

std::vector<double> Numbers(const YAML::Node& node, size_t count, const std::string& where) {
  const auto values = As<std::vector<double>>(node, where);
  TVL_CHECK_INPUT(values.size() == count)
      << where << ": want " << count << " numbers, has " << values.size();
  return values;
}

Camera WithDistortion(Camera camera, const YAML::Node& section, const std::string& source) {
  const YAML::Node model = section["distortion_model"], values = section["distortion"];
  const std::string name =
      model ? As<std::string>(model, Where(source, model, "camera.distortion_model")) : "plumb_bob";
  const auto known = std::find_if(kDistortions.begin(), kDistortions.end(),
                                  [&](const DistortionName& d) { return name == d.name; });
  TVL_CHECK_INPUT(known != kDistortions.end())
      << Where(source, model, "camera.distortion_model")
      << ": want plumb_bob, rational or equidistant, is '" << name << "'";
  camera.distortion_model = known->model;
  if (!values) return camera;
  const std::vector<double> given =
      Numbers(values, known->coefficients, Where(source, values, "camera.distortion"));
  std::copy(given.begin(), given.end(), camera.distortion.begin());
  return camera;
}

Camera CameraOf(const YAML::Node& section, const std::string& source) {
  TVL_CHECK_INPUT(section.IsMap()) << Where(source, section, "camera") << ": want a map";
  Camera camera;
  for (const auto& entry : section) {
    const auto key = entry.first.as<std::string>();
    const std::string where = Where(source, entry.first, "camera." + key);
    if (key == "intrinsics_px") {
      const std::vector<double> k = Numbers(entry.second, 4, where);
      camera.fx_px = k[0], camera.fy_px = k[1], camera.cx_px = k[2], camera.cy_px = k[3];
    } else if (key == "size_px") {
      const std::vector<double> size = Numbers(entry.second, 2, where);
      constexpr double kMost_px = 65535.0;
      TVL_CHECK_INPUT(size[0] >= 0.0 && size[1] >= 0.0 && size[0] <= kMost_px &&
                      size[1] <= kMost_px)
          << where << ": want a width and a height";
      camera.width_px = static_cast<int>(size[0]), camera.height_px = static_cast<int>(size[1]);
    } else {
      TVL_CHECK_INPUT(key == "distortion_model" || key == "distortion") << where << ": unknown key";
    }
  }
  TVL_CHECK_INPUT(camera.fx_px > 0.0 && camera.fy_px > 0.0)
      << Where(source, section, "camera") << ": intrinsics_px: [fx, fy, cx, cy] with fx, fy > 0 "
      << "are needed";
  return WithDistortion(camera, section, source);
}

std::string List(const std::vector<double>& values) {
  std::ostringstream out;
  out << std::setprecision(17) << "[";
  for (size_t i = 0; i < values.size(); ++i) out << (i > 0 ? ", " : "") << values[i];
  out << "]";
  return out.str();
}

void DumpLidar(const LidarModel& lidar, std::ostream& out) {
  out << "lidar:\n  name: \"" << lidar.name << "\"\n";
  std::vector<double> beams_deg;
  for (const double beam_rad : lidar.beam_elevation_rad) beams_deg.push_back(RadToDeg(beam_rad));
  if (!beams_deg.empty()) out << "  beam_elevation_deg: " << List(beams_deg) << "\n";
  if (!lidar.rows_are_beams) out << "  rows: slices\n";
  out << "  ring_start_azimuth_deg: " << RadToDeg(lidar.ring_start_azimuth_rad) << "\n"
      << "  columns: " << lidar.columns << "\n  sweep_s: " << lidar.sweep_s
      << "\n  range_sigma_m: " << lidar.range_sigma_m << "\n  min_range_m: " << lidar.min_range_m
      << "\n  max_range_m: " << lidar.max_range_m
      << "\n  vertical_correction_deg: " << RadToDeg(lidar.vertical_correction_rad) << "\n";
}

void DumpCamera(const Camera& camera, std::ostream& out) {
  const DistortionName& distortion = NameOf(camera.distortion_model);
  out << "camera:\n  intrinsics_px: "
      << List({camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px}) << "\n  size_px: ["
      << camera.width_px << ", " << camera.height_px << "]\n";
  if (!camera.IsDistorted()) return;
  const auto end = camera.distortion.begin() + static_cast<std::ptrdiff_t>(distortion.coefficients);
  out << "  distortion_model: " << distortion.name
      << "\n  distortion: " << List({camera.distortion.begin(), end}) << "\n";
}

}  // namespace

Rig ParseRig(const std::string& yaml, const std::string& source) {
  const YAML::Node root = ParseYaml(yaml, source);
  TVL_CHECK_INPUT(root.IsMap()) << source
                                << ": a rig is a map with lidar, camera, T_cam_lidar, ...";
  Rig rig;
  for (const auto& entry : root) {
    const auto key = entry.first.as<std::string>();
    const std::string where = Where(source, entry.first, key);
    if (key == "lidar") {
      rig.lidar = LidarOfSection(entry.second, source);
    } else if (key == "camera") {
      rig.camera = CameraOf(entry.second, source);
    } else if (key == "T_cam_lidar") {
      const std::vector<double> values = Numbers(entry.second, 12, where);
      const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(values.data());
      rig.T_cam_lidar = RigidOfMatrix(matrix, where);
    } else if (key == "lidar_topic") {
      rig.lidar_topic = As<std::string>(entry.second, where);
    } else if (key == "image_topic") {
      rig.image_topic = As<std::string>(entry.second, where);
    } else {
      throw InputError(where + ": unknown key");
    }
  }
  return rig;
}

Rig LoadRig(const std::string& path) { return ParseRig(ReadWholeText(path), path); }

std::string DumpRig(const Rig& rig) {
  std::ostringstream out;
  out << std::setprecision(17);
  if (rig.lidar) DumpLidar(*rig.lidar, out);
  if (rig.camera) DumpCamera(*rig.camera, out);
  if (rig.T_cam_lidar) {
    const Eigen::Matrix3d R = rig.T_cam_lidar->R();
    std::vector<double> values;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) values.push_back(R(row, column));
      values.push_back(rig.T_cam_lidar->t()[row]);
    }
    out << "T_cam_lidar: " << List(values) << "\n";
  }
  if (!rig.lidar_topic.empty()) out << "lidar_topic: \"" << rig.lidar_topic << "\"\n";
  if (!rig.image_topic.empty()) out << "image_topic: \"" << rig.image_topic << "\"\n";
  return out.str();
}

}  // namespace tvl
