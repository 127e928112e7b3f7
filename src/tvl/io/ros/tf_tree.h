// Transforms between the coordinate frames of a robot, as the topics /tf and /tf_static have them.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tvl/geometry/rigid3.h"
#include "tvl/io/ros/messages.h"

namespace tvl {

// Each frame hangs on one parent. Small: a robot has tens of frames.
class TfTree {
 public:
  // Says it for good: what is fixed. Of two that differ the last one counts, as in ROS.
  void AddStatic(const FrameTransform& transform);
  // Of the topic /tf. Has no effect on frames that AddStatic knows. A frame for which it says
  // different things moves, and cannot be used.
  void AddMoving(const FrameTransform& transform);
  bool empty() const { return links_.empty(); }

  // T_a_b maps points of frame b to frame a. Throws InputError naming the frames where no fixed
  // chain of transforms joins them, and for frames that are their own ancestors.
  Rigid3d Transform(const std::string& a, const std::string& b) const;
  // Whether Transform(a, b) would rest on what AddMoving said.
  bool RestsOnMoving(const std::string& a, const std::string& b) const;

 private:
  struct Link {
    std::string parent;
    Rigid3d T_parent_child;
    bool fixed = false;  // by AddStatic
    bool moves = false;
  };
  // The frames from `frame` to the last ancestor.
  std::vector<std::string> Ancestors(const std::string& frame) const;
  // The same of both, without the ancestors they share but the first.
  struct Branches {
    std::vector<std::string> a, b;
  };
  Branches BranchesOf(const std::string& a, const std::string& b) const;

  std::map<std::string, Link> links_;  // by the child
};

}  // namespace tvl
