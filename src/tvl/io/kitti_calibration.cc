#include "tvl/io/kitti_calibration.h"

#include <Eigen/LU>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "tvl/base/check.h"
#include "tvl/io/atomic_file.h"
#include "tvl/io/text_file.h"

namespace tvl {
namespace {

// Largest entry of R^T R - I that printed digits explain; a broken matrix has far more.
constexpr double kOrthonormalTolerance = 1e-3;

Matrix34d Matrix34Of(const std::vector<double>& row_major) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(row_major.data());
}

Eigen::Matrix3d Matrix33Of(const std::vector<double>& row_major) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(row_major.data());
}

// Each number after a blank, exactly enough to be read back.
std::string RowMajor(const Eigen::MatrixXd& m) {
  std::ostringstream out;
  out << std::scientific << std::setprecision(12);
  for (Eigen::Index row = 0; row < m.rows(); ++row) {
    for (Eigen::Index column = 0; column < m.cols(); ++column) out << " " << m(row, column);
  }
  return out.str();
}

}  // namespace

Rigid3d RigidOfMatrix(const Matrix34d& m, const std::string& where) {
  const Eigen::Matrix3d R = m.leftCols<3>();
  const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  TVL_CHECK_INPUT(error < kOrthonormalTolerance && R.determinant() > 0.0)
      << where << ": not a rotation (R^T R is off identity by " << error << ")";
  return Rigid3d::FromMatrix(m);
}

KittiCalibration ReadOdometryCalibration(const std::string& path) {
  const KeyedNumbers file(path);
  KittiCalibration kitti;
  kitti.source = path;
  for (size_t n = 0; n < kitti.P.size(); ++n) {
    const std::string key = "P" + std::to_string(n);
    if (file.Has(key)) kitti.P[n] = Matrix34Of(file.Get(key, 12));
  }
  const std::string key = file.Has("Tr_velo_to_cam") ? "Tr_velo_to_cam" : "Tr";
  kitti.T_cam0_lidar = RigidOfMatrix(Matrix34Of(file.Get(key, 12)), path + ": " + key);
  return kitti;
}

KittiCalibration ReadRawCalibration(const std::string& date_folder) {
  const KeyedNumbers cameras(date_folder + "/calib_cam_to_cam.txt");
  const KeyedNumbers velodyne(date_folder + "/calib_velo_to_cam.txt");
  KittiCalibration kitti;
  kitti.source = cameras.path();
  for (size_t n = 0; n < kitti.P.size(); ++n) {
    const std::string key = "P_rect_0" + std::to_string(n);
    if (cameras.Has(key)) kitti.P[n] = Matrix34Of(cameras.Get(key, 12));
  }
  Matrix34d rectification = Matrix34d::Zero();
  rectification.leftCols<3>() = Matrix33Of(cameras.Get("R_rect_00", 9));
  Matrix34d unrectified;
  unrectified.leftCols<3>() = Matrix33Of(velodyne.Get("R", 9));
  unrectified.col(3) = Eigen::Vector3d(velodyne.Get("T", 3).data());
  kitti.rectification = RigidOfMatrix(rectification, cameras.path() + ": R_rect_00");
  kitti.T_cam0_lidar = kitti.rectification * RigidOfMatrix(unrectified, velodyne.path() + ": R");
  return kitti;
}

Calibration CalibrationOfCamera(const KittiCalibration& kitti, int camera) {
  TVL_CHECK(camera >= 0 && camera < 4) << camera;
  const auto& P = kitti.P[static_cast<size_t>(camera)];
  TVL_CHECK_INPUT(P.has_value()) << kitti.source << ": no projection matrix for camera " << camera
                                 << ", whose images are there";
  const Eigen::Matrix3d K = P->leftCols<3>();
  const bool is_pinhole = K(0, 0) > 0.0 && K(1, 1) > 0.0 && K(0, 1) == 0.0 && K(1, 0) == 0.0 &&
                          K(2, 0) == 0.0 && K(2, 1) == 0.0 && K(2, 2) == 1.0;
  TVL_CHECK_INPUT(is_pinhole) << kitti.source << ": the projection matrix of camera " << camera
                              << " is not that of a rectified pinhole camera";
  Calibration calibration;
  calibration.camera.fx_px = K(0, 0);
  calibration.camera.fy_px = K(1, 1);
  calibration.camera.cx_px = K(0, 2);
  calibration.camera.cy_px = K(1, 2);
  const Eigen::Vector3d p_camN_cam0 = K.inverse() * P->col(3);
  calibration.T_cam0_lidar = kitti.T_cam0_lidar;
  calibration.T_cam_lidar =
      Rigid3d(Eigen::Quaterniond::Identity(), p_camN_cam0) * kitti.T_cam0_lidar;
  return calibration;
}

KittiCalibration KittiCalibrationOf(const Calibration& calibration) {
  KittiCalibration kitti;
  const Camera& camera = calibration.camera;
  Matrix34d P = Matrix34d::Zero();
  P.leftCols<3>() << camera.fx_px, 0.0, camera.cx_px, 0.0, camera.fy_px, camera.cy_px, 0.0, 0.0,
      1.0;
  kitti.P.fill(P);
  kitti.T_cam0_lidar = calibration.T_cam0_lidar;
  return kitti;
}

void WriteOdometryCalibration(const std::string& path, const KittiCalibration& kitti) {
  WriteAtomically(path, [&](std::ostream& file) {
    for (size_t n = 0; n < kitti.P.size(); ++n) {
      if (kitti.P[n]) file << "P" << n << ":" << RowMajor(*kitti.P[n]) << "\n";
    }
    Matrix34d Tr;
    Tr << kitti.T_cam0_lidar.R(), kitti.T_cam0_lidar.t();
    file << "Tr:" << RowMajor(Tr) << "\n";
  });
}

void WriteRawExtrinsics(const std::string& path, const KittiCalibration& kitti) {
  const Rigid3d T_velo_to_cam = kitti.rectification.Inverse() * kitti.T_cam0_lidar;
  WriteAtomically(path, [&](std::ostream& file) {
    file << "R:" << RowMajor(T_velo_to_cam.R()) << "\nT:" << RowMajor(T_velo_to_cam.t()) << "\n";
  });
}

Calibration CalibrationWithoutCamera(const KittiCalibration& kitti) {
  Calibration calibration;
  calibration.T_cam0_lidar = kitti.T_cam0_lidar;
  calibration.T_cam_lidar = kitti.T_cam0_lidar;
  return calibration;
}

}  // namespace tvl
