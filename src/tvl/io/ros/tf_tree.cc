#include "tvl/io/ros/tf_tree.h"

#include <algorithm>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Repeated transforms of what does not move are equal up to rounding.
constexpr double kSame = 1e-6;  // m and rad

bool IsSame(const Rigid3d& a, const Rigid3d& b) {
  return (a.t() - b.t()).norm() < kSame && (a.Inverse() * b).RotationAngle() < kSame;
}

// Frames from `branch`'s first to before its last, multiplied up.
template <typename Links>
Rigid3d ToLast(const Links& links, const std::vector<std::string>& branch) {
  Rigid3d T_last_first;
  for (size_t k = 0; k + 1 < branch.size(); ++k) {
    const auto& link = links.at(branch[k]);
    TVL_CHECK_INPUT(!link.moves) << "the transform from frame '" << link.parent << "' to '"
                                 << branch[k] << "' changes with time";
    T_last_first = link.T_parent_child * T_last_first;
  }
  return T_last_first;
}

}  // namespace

void TfTree::AddStatic(const FrameTransform& transform) {
  links_[transform.child] = {transform.parent, transform.T_parent_child, true, false};
}

void TfTree::AddMoving(const FrameTransform& transform) {
  const auto [link, is_new] = links_.emplace(
      transform.child, Link{transform.parent, transform.T_parent_child, false, false});
  if (is_new || link->second.fixed) return;
  link->second.moves = link->second.moves || link->second.parent != transform.parent ||
                       !IsSame(link->second.T_parent_child, transform.T_parent_child);
}

std::vector<std::string> TfTree::Ancestors(const std::string& frame) const {
  std::vector<std::string> chain = {frame};
  for (auto link = links_.find(frame); link != links_.end();
       link = links_.find(link->second.parent)) {
    TVL_CHECK_INPUT(chain.size() <= links_.size())
        << "frame '" << frame << "' is its own ancestor: the transforms run in a circle over '"
        << link->second.parent << "'";
    chain.push_back(link->second.parent);
  }
  return chain;
}

TfTree::Branches TfTree::BranchesOf(const std::string& a, const std::string& b) const {
  Branches branches = {Ancestors(a), Ancestors(b)};
  TVL_CHECK_INPUT(branches.a.back() == branches.b.back())
      << "no transform joins the frames '" << a << "' and '" << b << "' (their roots are '"
      << branches.a.back() << "' and '" << branches.b.back() << "')";
  const auto shared = [&branches] {
    return branches.a.size() > 1 && branches.b.size() > 1 &&
           branches.a[branches.a.size() - 2] == branches.b[branches.b.size() - 2];
  };
  while (shared()) branches.a.pop_back(), branches.b.pop_back();
  return branches;
}

Rigid3d TfTree::Transform(const std::string& a, const std::string& b) const {
  const Branches branches = BranchesOf(a, b);
  return ToLast(links_, branches.a).Inverse() * ToLast(links_, branches.b);
}

bool TfTree::RestsOnMoving(const std::string& a, const std::string& b) const {
  const Branches branches = BranchesOf(a, b);
  const auto any = [this](const std::vector<std::string>& branch) {
    return std::any_of(branch.begin(), branch.end() - 1,
                       [this](const std::string& f) { return !links_.at(f).fixed; });
  };
  return any(branches.a) || any(branches.b);
}

}  // namespace tvl
