#include "tvl/io/g2o.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/geometry/rigid3_matchers.h"
#include "tvl/io/temp_folder.h"

namespace tvl {
namespace {

constexpr char kVertices[] =
    "VERTEX_SE3:QUAT 10 1 2 3 0 0 0 1\n"
    "VERTEX_SE3:QUAT 20 4 5 6 0 0 1 0\n";

Rigid3d RandomPose(Rng* rng) {
  Vector6d xi;
  for (int i = 0; i < 6; ++i) xi[i] = (i < 3 ? 1.0 : 100.0) * rng->Normal();
  return Rigid3d::Exp(xi);
}

PoseConstraint RandomConstraint(int from, int to, Rng* rng) {
  Matrix6d A;
  for (int i = 0; i < 36; ++i) A(i / 6, i % 6) = rng->Normal();
  return {from, to, RandomPose(rng), A * A.transpose() + Matrix6d::Identity()};
}

std::string ErrorOf(const std::string& text) {
  const TempFolder folder;
  try {
    ReadG2o(folder.Write("g.g2o", text));
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

TEST(G2o, RoundTrip) {
  Rng rng(1);
  PoseGraph graph;
  for (int k = 0; k < 6; ++k) graph.T_world.push_back(RandomPose(&rng));
  for (int k = 1; k < 6; ++k) graph.odometry.push_back(RandomConstraint(k - 1, k, &rng));
  graph.loops = {RandomConstraint(0, 4, &rng), RandomConstraint(5, 2, &rng)};
  const TempFolder folder;
  WriteG2o(folder / "g.g2o", graph);
  const PoseGraph read = ReadG2o(folder / "g.g2o");
  ASSERT_EQ(read.T_world.size(), 6U);
  ASSERT_EQ(read.odometry.size(), 5U);
  ASSERT_EQ(read.loops.size(), 2U);
  for (int k = 0; k < 6; ++k) {
    EXPECT_THAT(read.T_world[k], Rigid3dNear(graph.T_world[k], 1e-14, 1e-12));
  }
  const auto expect_same = [](const PoseConstraint& a, const PoseConstraint& b) {
    EXPECT_EQ(a.from, b.from);
    EXPECT_EQ(a.to, b.to);
    EXPECT_THAT(a.T_from_to, Rigid3dNear(b.T_from_to, 1e-14, 1e-12));
    EXPECT_LT((a.information - b.information).norm(), 1e-13 * b.information.norm());
  };
  for (int k = 0; k < 5; ++k) expect_same(read.odometry[k], graph.odometry[k]);
  for (int k = 0; k < 2; ++k) expect_same(read.loops[k], graph.loops[k]);
}

TEST(G2o, InformationIsThatOfTheSameCost) {
  // The format's cost of a small error, computed as the format defines it, against ours.
  const TempFolder folder;
  std::string numbers;
  Matrix6d format;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      format(row, column) = format(column, row) = row == column ? 10.0 + row : 0.1 * (row + column);
      numbers += " " + std::to_string(format(row, column));
    }
  }
  const std::string edge = "EDGE_SE3:QUAT 10 20 0 0 0 0 0 0 1" + numbers + "\n";
  const PoseGraph graph = ReadG2o(folder.Write("g.g2o", kVertices + edge));
  Vector6d xi;
  xi << 1e-5, -2e-5, 3e-5, 4e-5, 1e-5, -2e-5;
  const Rigid3d T = Rigid3d::Exp(xi);
  Vector6d e;
  e << T.t(), T.q().vec();
  const double expected = e.dot(format * e);
  EXPECT_NEAR(xi.dot(graph.odometry[0].information * xi), expected, 1e-4 * expected);
}

TEST(G2o, IdsAreRenumberedAndEdgesSorted) {
  const std::string identity = " 0 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n";
  const TempFolder folder;
  const PoseGraph graph = ReadG2o(folder.Write(
      "g.g2o", "# a comment\n\nFIX 10\nVERTEX_SE3:QUAT 30 7 8 9 0 0 0 1\n" +
                   std::string(kVertices) + "EDGE_SE3:QUAT 10 20" + identity +
                   "EDGE_SE3:QUAT 10 20" + identity + "EDGE_SE3:QUAT 30 10" + identity));
  ASSERT_EQ(graph.T_world.size(), 3U);
  EXPECT_EQ(graph.T_world[2].t().x(), 7.0);
  EXPECT_NEAR(graph.T_world[1].RotationAngle(), 3.14159265, 1e-6);
  ASSERT_EQ(graph.odometry.size(), 1U);
  ASSERT_EQ(graph.loops.size(), 2U);  // the repeated one and the one back
  EXPECT_EQ(graph.loops[1].from, 2);
  EXPECT_EQ(graph.loops[1].to, 0);
}

TEST(G2o, ErrorsNameTheLine) {
  const std::string vertices = kVertices;
  EXPECT_THAT(ErrorOf(""), testing::HasSubstr("no VERTEX_SE3:QUAT"));
  EXPECT_THAT(ErrorOf(vertices + "VERTEX_SE2 0 0 0 0\n"),
              testing::HasSubstr("g.g2o:3: unknown tag `VERTEX_SE2`"));
  EXPECT_THAT(ErrorOf("VERTEX_SE3:QUAT 1 2 3\n"), testing::HasSubstr("g.g2o:1: want 8 numbers"));
  EXPECT_THAT(ErrorOf(vertices + vertices),
              testing::HasSubstr("g.g2o:3: vertex 10 is there twice"));
  EXPECT_THAT(ErrorOf("VERTEX_SE3:QUAT 1 0 0 0 0 0 0 2\n"), testing::HasSubstr("unit length"));
  EXPECT_THAT(ErrorOf("VERTEX_SE3:QUAT 1.5 0 0 0 0 0 0 1\n"), testing::HasSubstr("is no id"));
  const std::string pose = " 0 0 0 0 0 0 1";
  const std::string identity = " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n";
  const std::string zero = " 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0\n";
  EXPECT_THAT(ErrorOf(vertices + "EDGE_SE3:QUAT 10 30" + pose + identity),
              testing::HasSubstr("g.g2o:3: there is no vertex 30"));
  EXPECT_THAT(ErrorOf(vertices + "EDGE_SE3:QUAT 10 10" + pose + identity),
              testing::HasSubstr("to itself"));
  EXPECT_THAT(ErrorOf(vertices + "EDGE_SE3:QUAT 10 20" + pose + zero),
              testing::HasSubstr("g.g2o:3: the information"));
  EXPECT_THAT(ErrorOf(vertices + "EDGE_SE3:QUAT 10 20" + pose + "\n"),
              testing::HasSubstr("want 30 numbers"));
  EXPECT_THROW(ReadG2o("does-not-exist.g2o"), InputError);
}

}  // namespace
}  // namespace tvl
