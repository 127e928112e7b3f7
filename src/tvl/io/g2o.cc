#include "tvl/io/g2o.h"

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <map>
#include <ostream>
#include <set>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/io/atomic_file.h"
#include "tvl/io/text_file.h"

namespace tvl {
namespace {

// Files are written with 6 digits at least; beyond this a quaternion is none.
constexpr double kUnitTolerance = 1e-2;
// Beyond 2^53 numbers read as double are no longer ids.
constexpr double kMaxId = 9007199254740992.0;

int64_t IdOf(double number, const std::string& where) {
  TVL_CHECK_INPUT(number == std::floor(number) && std::abs(number) < kMaxId)
      << where << ": `" << number << "` is no id";
  return static_cast<int64_t>(number);
}

// x y z qx qy qz qw.
Rigid3d PoseOf(const double* v, const std::string& where) {
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  TVL_CHECK_INPUT(std::abs(q.norm() - 1.0) < kUnitTolerance)
      << where << ": the quaternion is not of unit length";
  return {q, Eigen::Vector3d(v[0], v[1], v[2])};
}

// d [translation, quaternion vector part] / d [rotation, translation] at zero.
Matrix6d FormatJacobian() {
  Matrix6d J = Matrix6d::Zero();
  J.topRightCorner<3, 3>().setIdentity();
  J.bottomLeftCorner<3, 3>() = 0.5 * Eigen::Matrix3d::Identity();
  return J;
}

// From the 21 numbers of the upper triangle, row by row.
Matrix6d InformationOf(const double* v, const std::string& where) {
  Matrix6d information;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      information(row, column) = information(column, row) = *v++;
    }
  }
  TVL_CHECK_INPUT(information.llt().info() == Eigen::Success)
      << where << ": the information is not positive definite";
  const Matrix6d J = FormatJacobian();
  return J.transpose() * information * J;
}

struct Edge {
  int64_t from, to;
  PoseConstraint constraint;
  std::string where;
};

struct File {
  std::map<int64_t, Rigid3d> poses;
  std::vector<Edge> edges;
};

void ParseLine(const std::string& line, const std::string& where, File* file) {
  const size_t begin = line.find_first_not_of(" \t");
  if (begin == std::string::npos || line[begin] == '#') return;
  const size_t end = std::min(line.find_first_of(" \t", begin), line.size());
  const std::string tag = line.substr(begin, end - begin);
  if (tag == "FIX") return;
  const bool is_vertex = tag == "VERTEX_SE3:QUAT";
  TVL_CHECK_INPUT(is_vertex || tag == "EDGE_SE3:QUAT") << where << ": unknown tag `" << tag << "`";
  const std::vector<double> v = ParseNumbers(line.substr(end), where);
  const size_t count = is_vertex ? 8 : 30;
  TVL_CHECK_INPUT(v.size() == count)
      << where << ": want " << count << " numbers after " << tag << ", has " << v.size();
  if (is_vertex) {
    const int64_t id = IdOf(v[0], where);
    TVL_CHECK_INPUT(file->poses.emplace(id, PoseOf(v.data() + 1, where)).second)
        << where << ": vertex " << id << " is there twice";
    return;
  }
  PoseConstraint constraint;
  constraint.T_from_to = PoseOf(v.data() + 2, where);
  constraint.information = InformationOf(v.data() + 9, where);
  file->edges.push_back({IdOf(v[0], where), IdOf(v[1], where), constraint, where});
}

void WritePose(const Rigid3d& T, std::ostream* out) {
  for (int i = 0; i < 3; ++i) *out << " " << T.t()[i];
  *out << " " << T.q().x() << " " << T.q().y() << " " << T.q().z() << " " << T.q().w();
}

void WriteEdge(const PoseConstraint& c, std::ostream* out) {
  *out << "EDGE_SE3:QUAT " << c.from << " " << c.to;
  WritePose(c.T_from_to, out);
  const Matrix6d J = FormatJacobian().inverse();
  const Matrix6d information = J.transpose() * c.information * J;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) *out << " " << information(row, column);
  }
  *out << "\n";
}

}  // namespace

PoseGraph ReadG2o(const std::string& path) {
  File file;
  const std::vector<std::string> lines = ReadLines(path);
  for (size_t i = 0; i < lines.size(); ++i) ParseLine(lines[i], LineOf(path, i), &file);
  TVL_CHECK_INPUT(!file.poses.empty()) << path << ": no VERTEX_SE3:QUAT";

  PoseGraph graph;
  std::map<int64_t, int> index;
  for (const auto& [id, T_world] : file.poses) {
    index[id] = static_cast<int>(graph.T_world.size());
    graph.T_world.push_back(T_world);
  }
  std::set<int> has_odometry;  // poses an odometry edge leads to
  for (Edge& edge : file.edges) {
    for (const int64_t id : {edge.from, edge.to}) {
      TVL_CHECK_INPUT(index.count(id) > 0) << edge.where << ": there is no vertex " << id;
    }
    TVL_CHECK_INPUT(edge.from != edge.to)
        << edge.where << ": an edge of vertex " << edge.from << " to itself";
    edge.constraint.from = index[edge.from];
    edge.constraint.to = index[edge.to];
    const bool is_odometry = edge.constraint.to == edge.constraint.from + 1 &&
                             has_odometry.insert(edge.constraint.to).second;
    (is_odometry ? graph.odometry : graph.loops).push_back(edge.constraint);
  }
  return graph;
}

void WriteG2o(const std::string& path, const PoseGraph& graph) {
  WriteAtomically(path, [&](std::ostream& out) {
    out.precision(std::numeric_limits<double>::max_digits10);
    for (size_t k = 0; k < graph.T_world.size(); ++k) {
      out << "VERTEX_SE3:QUAT " << k;
      WritePose(graph.T_world[k], &out);
      out << "\n";
    }
    for (const PoseConstraint& c : graph.odometry) WriteEdge(c, &out);
    for (const PoseConstraint& c : graph.loops) WriteEdge(c, &out);
  });
}

}  // namespace tvl
