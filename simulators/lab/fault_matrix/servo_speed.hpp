/// @file  How much faster than its set point a servo gets: what a limit on commands promises of a joint.
#pragma once

namespace motionlab::matrix {

/// A position loop x'' = w² (u − x) − 2 zeta w x' with 0 < zeta < 1.
struct ServoLoop {
  double omega_radps = 0;
  double zeta = 0;
};

/// The most that |x'| can be of `speed_max`, for every set point u that begins at rest, is never faster than
/// `speed_max` and never changes its speed by more than `acceleration_max` (infinity: at once). Exact: one of
/// these set points reaches it.
///
/// From u' to x' leads the loop's own transfer, whose step response s overshoots by M = exp(−pi zeta / r),
/// r = sqrt(1 − zeta²). The worst u' reverses between ±speed_max in the rhythm of the ringing, half a period
/// h = pi / (w r) apart. A reversal takes T = 2 speed_max / acceleration_max, so that it adds not 2 M but 2
/// m, with m the mean of s − 1 over the time T round its peak, where s is equal at both ends; the reversal
/// before it adds M times as much: together 1 + 2 m / (1 − M). Immediate reversals make that (1 + M) / (1 −
/// M), the absolute area under the impulse response. Where T > h there is no time to reverse fully; T = h
/// bounds that from above.
[[nodiscard]] double servo_speed_share(ServoLoop loop, double speed_max, double acceleration_max);

}  // namespace motionlab::matrix
