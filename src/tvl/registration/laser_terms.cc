#include "tvl/registration/laser_terms.h"

#include "tvl/geometry/robust.h"
#include "tvl/registration/beam_directions.h"

namespace tvl {
namespace {

constexpr size_t kChunk = 256;

// Adds one whitened residual block; returns its robust weight times information.
template <int N>
double Accumulate(const Residual<N>& residual, double information, double kernel_sigmas,
                  const Matrix6d* J_bin, NormalEquations* sum) {
  const RobustValue robust = Cauchy(residual.r.squaredNorm() * information, kernel_sigmas);
  const double weight = robust.weight * information;
  const Eigen::Matrix<double, N, 6> J =
      J_bin == nullptr ? residual.J : Eigen::Matrix<double, N, 6>(residual.J * *J_bin);
  sum->H.template selfadjointView<Eigen::Lower>().rankUpdate(J.transpose(), weight);
  sum->b.noalias() += weight * J.transpose() * residual.r;
  sum->cost += 0.5 * robust.rho;
  return weight;
}

void AddLever(const Eigen::Vector3d& p_body, const Eigen::Matrix<double, 1, 3>& J_rotation,
              double weight, LaserSum* sum) {
  Eigen::Matrix3d& lever = sum->plane_lever_m2;
  lever.diagonal().array() += weight * p_body.squaredNorm();
  lever.noalias() -= (weight * p_body) * p_body.transpose();
  lever.noalias() -= (weight * J_rotation.transpose()) * J_rotation;
}

void AddBeam(const PlaneMatch& match, const Residual<1>& residual, double weight,
             std::vector<BeamSum>* beams) {
  const auto beam = static_cast<size_t>(match.beam);
  if (beam >= beams->size()) beams->resize(beam + 1);
  BeamSum& sum = (*beams)[beam];
  // By the translation the residual changes with the normal in the body's frame.
  const double J_m =
      residual.J.tail<3>().dot(DirectionsAt(match.factor.p_body).elevation.transpose());
  sum.cross += (weight * J_m) * residual.J.transpose();
  sum.information += weight * J_m * J_m;
  sum.b += weight * J_m * residual.r[0];
}

template <typename Match>
LaserSum LinearizeRange(const std::vector<Match>& matches, size_t begin, size_t end,
                        const SweepMotion& motion, double kernel_sigmas) {
  LaserSum sum;
  const bool one_bin = motion.bins.size() == 1;
  for (size_t i = begin; i < end; ++i) {
    const SweepMotion::Bin& bin = motion.bins[static_cast<size_t>(matches[i].bin)];
    const auto residual = Evaluate(matches[i].factor, bin.R, bin.t);
    const double weight = Accumulate(residual, matches[i].information, kernel_sigmas,
                                     one_bin ? nullptr : &bin.J, &sum.normal);
    if constexpr (std::is_same_v<Match, PlaneMatch>) {
      sum.plane_sq_m2 += residual.r.squaredNorm();
      sum.plane_information += weight;
      AddLever(matches[i].factor.p_body, residual.J.template head<3>(), weight, &sum);
      if (matches[i].beam >= 0) AddBeam(matches[i], residual, weight, &sum.beams);
    } else {
      sum.line_sq_m2 += residual.r.squaredNorm();
    }
  }
  return sum;
}

}  // namespace

LaserSum& LaserSum::operator+=(const LaserSum& other) {
  normal += other.normal;
  if (beams.size() < other.beams.size()) beams.resize(other.beams.size());
  for (size_t k = 0; k < other.beams.size(); ++k) {
    beams[k].cross += other.beams[k].cross;
    beams[k].information += other.beams[k].information;
    beams[k].b += other.beams[k].b;
  }
  plane_sq_m2 += other.plane_sq_m2;
  line_sq_m2 += other.line_sq_m2;
  plane_information += other.plane_information;
  plane_lever_m2 += other.plane_lever_m2;
  return *this;
}

NormalEquations WithBeamErrors(const LaserSum& sum, double sigma_rad) {
  NormalEquations rest = sum.normal;
  if (sigma_rad <= 0.0) return rest;
  for (const BeamSum& beam : sum.beams) {
    const double gain = 1.0 / (beam.information + 1.0 / (sigma_rad * sigma_rad));
    rest.H -= gain * beam.cross * beam.cross.transpose();
    rest.b -= gain * beam.b * beam.cross;
    rest.cost -= 0.5 * gain * beam.b * beam.b;
  }
  return rest;
}

LaserSum Linearize(const LaserMatches& matches, const Rigid3d& T, const SweepBins& bins,
                   double kernel_sigmas, const Executor& executor) {
  const SweepMotion motion(bins, T);
  LaserSum sum = executor.Sum(matches.planes.size(), kChunk, LaserSum(), [&](size_t b, size_t e) {
    return LinearizeRange(matches.planes, b, e, motion, kernel_sigmas);
  });
  sum += executor.Sum(matches.lines.size(), kChunk, LaserSum(), [&](size_t b, size_t e) {
    return LinearizeRange(matches.lines, b, e, motion, kernel_sigmas);
  });
  sum.normal.H = Matrix6d(sum.normal.H.selfadjointView<Eigen::Lower>());
  return sum;
}

}  // namespace tvl
