#include "tvl/io/ros/tf_tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/base/check.h"

namespace tvl {
namespace {

using testing::HasSubstr;

const Rigid3d kTurn(Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ())),
                    Eigen::Vector3d(1, 2, 3));
const Rigid3d kShift = Rigid3d::Translation(0.1, -0.2, 0.3);

std::string TextOfError(const TfTree& tree, const std::string& a, const std::string& b) {
  try {
    tree.Transform(a, b);
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

void ExpectSame(const Rigid3d& a, const Rigid3d& b) {
  EXPECT_LT((a.Matrix() - b.Matrix()).norm(), 1e-12);
}

TEST(TfTree, JoinsBranchesAndAncestors) {
  TfTree tree;
  tree.AddStatic({"map", "base", kTurn});
  tree.AddStatic({"base", "lidar", kShift});
  tree.AddStatic({"base", "mast", kTurn});
  tree.AddStatic({"mast", "camera", kShift});
  ExpectSame(tree.Transform("base", "lidar"), kShift);
  ExpectSame(tree.Transform("lidar", "base"), kShift.Inverse());
  ExpectSame(tree.Transform("camera", "lidar"), (kTurn * kShift).Inverse() * kShift);
  ExpectSame(tree.Transform("lidar", "lidar"), Rigid3d());
  EXPECT_FALSE(tree.RestsOnMoving("camera", "lidar"));
}

TEST(TfTree, MissingLinksAndCirclesAreNamed) {
  TfTree tree;
  tree.AddStatic({"base", "lidar", kShift});
  tree.AddStatic({"other", "camera", kShift});
  EXPECT_THAT(TextOfError(tree, "camera", "lidar"), HasSubstr("'camera' and 'lidar'"));
  EXPECT_THAT(TextOfError(tree, "nowhere", "lidar"), HasSubstr("'nowhere'"));
  tree.AddStatic({"lidar", "base", kShift});
  EXPECT_THAT(TextOfError(tree, "camera", "lidar"), HasSubstr("its own ancestor"));
  tree.AddStatic({"self", "self", kShift});
  EXPECT_THAT(TextOfError(tree, "self", "camera"), HasSubstr("its own ancestor"));
}

TEST(TfTree, WhatMovesCannotBeUsed) {
  TfTree tree;
  tree.AddStatic({"base", "lidar", kShift});
  for (int k = 0; k < 3; ++k) {
    tree.AddMoving({"base", "camera", kTurn});
    tree.AddMoving({"odom", "base", Rigid3d::Translation(k, 0, 0)});
    tree.AddMoving({"base", "lidar", kTurn});  // the static topic knows better
  }
  ExpectSame(tree.Transform("camera", "lidar"), kTurn.Inverse() * kShift);
  EXPECT_TRUE(tree.RestsOnMoving("camera", "lidar"));
  EXPECT_THAT(TextOfError(tree, "odom", "lidar"), HasSubstr("changes with time"));
}

}  // namespace
}  // namespace tvl
