#include "tvl/geometry/point_index.h"

#include <array>
#include <nanoflann.hpp>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// The view nanoflann wants of a vector of points.
struct Cloud {
  std::vector<Eigen::Vector3f> points;
  size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(size_t i, size_t dim) const {
    return points[i][static_cast<Eigen::Index>(dim)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Cloud>, Cloud,
                                                 3, uint32_t>;
constexpr size_t kMaxNeighbours = 16;

}  // namespace

struct PointIndex::Impl {
  explicit Impl(std::vector<Eigen::Vector3f> points)
      : cloud{std::move(points)}, tree(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(16)) {
    tree.buildIndex();
  }
  Cloud cloud;
  Tree tree;
};

PointIndex::PointIndex() : PointIndex(std::vector<Eigen::Vector3f>()) {}
PointIndex::PointIndex(std::vector<Eigen::Vector3f> points)
    : impl_(std::make_unique<Impl>(std::move(points))) {}
PointIndex::~PointIndex() = default;
PointIndex::PointIndex(PointIndex&&) noexcept = default;
PointIndex& PointIndex::operator=(PointIndex&&) noexcept = default;

size_t PointIndex::size() const { return impl_->cloud.points.size(); }
const std::vector<Eigen::Vector3f>& PointIndex::points() const { return impl_->cloud.points; }

size_t PointIndex::Nearest(const Eigen::Vector3f& p, size_t k, Neighbour* out) const {
  TVL_CHECK(k <= kMaxNeighbours) << "at most " << kMaxNeighbours << " neighbours, asked for " << k;
  if (size() == 0) return 0;
  std::array<uint32_t, kMaxNeighbours> index;
  std::array<float, kMaxNeighbours> distance_sq;
  const size_t found = impl_->tree.knnSearch(p.data(), k, index.data(), distance_sq.data());
  for (size_t i = 0; i < found; ++i) out[i] = {index[i], distance_sq[i]};
  return found;
}

}  // namespace tvl
