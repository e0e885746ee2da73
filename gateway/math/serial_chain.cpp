#include "gateway/math/serial_chain.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace motionlab::math {

namespace {

/// phi with rotation_of(phi) = R, of length at most pi.
Vector3d rotation_vector(const Matrix3d& R) {
  const Vector3d twice_sine(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  const double s = 0.5 * twice_sine.norm(), c = 0.5 * (R.trace() - 1);
  if (s < 1e-6 && c < 0) {
    // A half turn: its axis is the column of R + I that is longest.
    const Matrix3d axes = R + Matrix3d::Identity();
    Eigen::Index column = 0;
    axes.colwise().squaredNorm().maxCoeff(&column);
    return std::atan2(s, c) * axes.col(column).normalized();
  }
  return (s > 1e-6 ? std::atan2(s, c) / s : 1.0) * 0.5 * twice_sine;
}

}  // namespace

/// Axes and origins of the frames, where the Jacobians come from.
template <int N>
struct SerialChain<N>::Posture {
  std::array<Vector3d, N> axis;    ///< of joint i, in the base
  std::array<Vector3d, N> origin;  ///< of frame i − 1, in the base
  RigidTransform X_RT;
};

template <int N>
SerialChain<N>::SerialChain(const std::array<DhLink, N>& links, const JointMap<N>& joints,
                            const RigidTransform& X_flange_tool)
    : joints_(joints), X_FT_(X_flange_tool) {
  for (std::size_t i = 0; i < N; ++i) {
    links_[i] = {links[i].d_m, links[i].a_m, std::cos(links[i].alpha_rad), std::sin(links[i].alpha_rad)};
  }
}

template <int N>
typename SerialChain<N>::Posture SerialChain<N>::posture(const Joints& q) const {
  const Joints theta = joints_.S * q + joints_.offset_rad;
  Posture at;
  Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ(), p = Vector3d::Zero();
  for (std::size_t i = 0; i < N; ++i) {
    at.axis[i] = z;
    at.origin[i] = p;
    const Link& link = links_[i];
    const double c = std::cos(theta[static_cast<int>(i)]), s = std::sin(theta[static_cast<int>(i)]);
    const Vector3d turned = c * y - s * x;
    x = c * x + s * y;
    p += link.d * z + link.a * x;
    y = link.cos_alpha * turned + link.sin_alpha * z;
    z = link.cos_alpha * z - link.sin_alpha * turned;
  }
  Matrix3d R;
  R << x, y, z;
  at.X_RT = RigidTransform{R, p} * X_FT_;
  return at;
}

template <int N>
RigidTransform SerialChain<N>::tool(const Joints& q) const {
  return posture(q).X_RT;
}

template <int N>
typename SerialChain<N>::Frames SerialChain<N>::frames(const Joints& q) const {
  const Joints theta = joints_.S * q + joints_.offset_rad;
  Frames X;
  for (std::size_t i = 0; i < N; ++i) {
    const double c = std::cos(theta[static_cast<int>(i)]), s = std::sin(theta[static_cast<int>(i)]);
    const Link& link = links_[i];
    RigidTransform A;
    A.R << c, -s * link.cos_alpha, s * link.sin_alpha, s, c * link.cos_alpha, -c * link.sin_alpha, 0,
        link.sin_alpha, link.cos_alpha;
    A.p << link.a * c, link.a * s, link.d;
    X[i + 1] = X[i] * A;
  }
  X[N + 1] = X[N] * X_FT_;
  return X;
}

template <int N>
typename SerialChain<N>::Jacobian SerialChain<N>::jacobian(const Posture& at) const {
  Jacobian J;
  for (std::size_t i = 0; i < N; ++i) {
    J.col(static_cast<int>(i)) << at.axis[i].cross(at.X_RT.p - at.origin[i]), at.axis[i];
  }
  return J * joints_.S;
}

template <int N>
typename SerialChain<N>::Jacobian SerialChain<N>::jacobian(const Joints& q) const {
  return jacobian(posture(q));
}

template <int N>
typename SerialChain<N>::Jacobian SerialChain<N>::jacobian_dot(const Joints& q, const Joints& qd) const {
  const Posture at = posture(q);
  const Joints theta_dot = joints_.S * qd;
  // How each joint's frame turns and moves: the sum over the joints below it.
  std::array<Vector3d, N> axis_dot, origin_dot;
  Vector3d omega = Vector3d::Zero(), v = Vector3d::Zero(), before = Vector3d::Zero();
  for (std::size_t i = 0; i < N; ++i) {
    v += omega.cross(at.origin[i] - before);
    before = at.origin[i];
    origin_dot[i] = v;
    axis_dot[i] = omega.cross(at.axis[i]);
    omega += theta_dot[static_cast<int>(i)] * at.axis[i];
  }
  const Vector3d tool_dot = v + omega.cross(at.X_RT.p - before);
  Jacobian Jd;
  for (std::size_t i = 0; i < N; ++i) {
    Jd.col(static_cast<int>(i)) << axis_dot[i].cross(at.X_RT.p - at.origin[i]) +
                                       at.axis[i].cross(tool_dot - origin_dot[i]),
        axis_dot[i];
  }
  return Jd * joints_.S;
}

template <int N>
typename SerialChain<N>::Vector6 SerialChain<N>::acceleration(const Joints& q, const Joints& qd,
                                                              const Joints& qdd) const {
  return jacobian(q) * qdd + jacobian_dot(q, qd) * qd;
}

template <int N>
InverseResult<N> SerialChain<N>::inverse(const RigidTransform& X_RT, const Joints& start,
                                         const InverseOptions& options) const {
  const auto error_of = [&](const Posture& at) {
    Vector6 e;
    e << X_RT.p - at.X_RT.p, rotation_vector(X_RT.R * at.X_RT.R.transpose());
    return e;
  };
  const auto cost_of = [&](const Vector6& e) {
    return e.template head<3>().squaredNorm() +
           options.length_m * options.length_m * e.template tail<3>().squaredNorm();
  };
  Vector6 weight;
  weight << 1, 1, 1, options.length_m, options.length_m, options.length_m;

  InverseResult<N> result;
  result.q = start;
  Posture at = posture(start);
  Vector6 e = error_of(at);
  double cost = cost_of(e);
  double damping = 1e-3;
  for (;; ++result.iterations) {
    result.position_error_m = e.template head<3>().norm();
    result.rotation_error_rad = e.template tail<3>().norm();
    result.reached = result.position_error_m <= options.position_tolerance_m &&
                     result.rotation_error_rad <= options.rotation_tolerance_rad;
    if (result.reached || result.iterations >= options.most_iterations) return result;
    const Jacobian J = weight.asDiagonal() * jacobian(at);
    const Eigen::Matrix<double, N, N> JtJ = J.transpose() * J;
    const Joints pull = J.transpose() * (weight.asDiagonal() * e);
    // Damping in proportion to the error lets the steps become Newton's near the goal.
    bool better = false;
    for (int attempt = 0; attempt < 20 && !better; ++attempt) {
      Eigen::Matrix<double, N, N> M = JtJ;
      M.diagonal().array() += damping * std::min(cost, 1.0) + 1e-15;
      Joints step = M.ldlt().solve(pull);
      const double longest = step.cwiseAbs().maxCoeff();
      if (longest > options.largest_step_rad) step *= options.largest_step_rad / longest;
      const Joints q = result.q + step;
      const Posture there = posture(q);
      const Vector6 e_there = error_of(there);
      const double cost_there = cost_of(e_there);
      better = cost_there < cost;
      if (better) {
        result.q = q;
        at = there;
        e = e_there;
        cost = cost_there;
        damping = std::max(0.2 * damping, 1e-9);
      } else {
        damping = std::min(10 * damping, 1e9);
      }
    }
    if (!better) return result;
  }
}

template class SerialChain<1>;
template class SerialChain<3>;
template class SerialChain<6>;

}  // namespace motionlab::math
