/// @file  The estimator: from MRU, cameras, joints and winch to ship, tool, wire and load in the world.
#pragma once

#include <array>
#include <optional>

#include "drivers/core/time.hpp"
#include "gateway/estimator/arm_history.hpp"
#include "gateway/estimator/belief.hpp"
#include "gateway/estimator/innovations.hpp"
#include "gateway/estimator/mru_readings.hpp"
#include "gateway/estimator/second_ship.hpp"
#include "gateway/estimator/ship_model.hpp"
#include "gateway/estimator/ship_states.hpp"
#include "gateway/math/moving_base.hpp"
#include "gateway/math/sparse_kalman.hpp"
#include "idl/arm_state.hpp"
#include "idl/bodies.hpp"
#include "idl/estimate.hpp"
#include "idl/mru.hpp"
#include "idl/winch_state.hpp"

namespace motionlab::estimator {

/// The newest sample of each source at one time. A sample that was seen before does no harm.
struct Inputs {
  LabTime t{};
  std::optional<topic::Mru> mru;
  std::optional<topic::Bodies> load;
  std::optional<topic::Bodies> platform;
  std::optional<topic::ArmState> arm;
  std::optional<topic::WinchState> winch;
  std::optional<topic::Mru> second_mru;  ///< of the second ship
};

/// An extended Kalman filter on a time line a little in the past.
///
/// Measurements wait until `fusion_delay_s` has passed since they were taken, so that they are used in order
/// of measurement whatever their latency, with the joints of that very time; the state is then carried
/// forward to the present. A step takes in one measurement, of either ship: several that fall due together
/// are spread over the next steps, so that no step is much longer than another. Of the MRU it uses the
/// angles, the rates and the unfiltered accelerations, never the positions: those are high-passed and hold
/// nothing that the accelerations do not. Of the joints only the position of the tool enters, so the joint
/// dynamics need not be known. Without a tracked platform body the load itself is the seismometer: where it
/// is pulled to tells where the tool point is.
///
/// States (40): the ship and its unit's errors (33, see ShipStates), load position and velocity in W,
/// horizontal (4), offset of the tool point in W (3). The second ship has a filter of its own.
///
/// Before joints, winch, MRU and load have each been heard once, the estimate is not `valid`. When a source
/// falls silent the state is carried on without it; its standard deviations grow and the service decides what
/// to do. When the load is seen elsewhere than expected for 40 sightings in a row (somebody pushed it), it is
/// placed where it is seen. When time jumps by more than 2 s, everything begins anew.
class LabEstimator {
 public:
  explicit LabEstimator(const Belief& belief);

  /// Takes in what is new and returns the state at `inputs.t`. Never allocates, never throws.
  topic::Estimate step(const Inputs& inputs);

  /// Measurements refused: by the gate, not finite or of impossible size, come too late to be used in order,
  /// stamped in the future, or taken while the MRU called itself unstable.
  [[nodiscard]] std::uint64_t refused() const { return refused_; }
  /// What the filter was told against what it expected, of each kind of reading.
  [[nodiscard]] const Innovations& innovations(Reading kind) const {
    return innovations_[static_cast<std::size_t>(kind)];
  }

 private:
  static constexpr int kLoad = ShipStates::kSize;  // x, y
  static constexpr int kLoadVelocity = kLoad + 2;  // x, y
  static constexpr int kToolOffset = kLoadVelocity + 2;
  static constexpr int kStates = kToolOffset + 3;

  using Filter = math::KalmanState<kStates>;
  using Updates = math::SparseUpdates<kStates, kMruReadings>;
  using Vector2d = Eigen::Vector2d;
  using Vector3d = Eigen::Vector3d;

  static constexpr int axis(int i, int derivative = 0) { return ShipStates::axis(i, derivative); }

  struct Pending {
    enum class Kind { none, mru, load, platform } kind = Kind::none;
    LabTime t{};
    topic::Mru mru;
    topic::Bodies body;
  };

  /// The tool point in W at one time, and how it depends on the ship's state.
  struct Tool {
    math::PointMotion motion;
    Vector3d p_BT;
    Eigen::Matrix3d d_euler;  ///< ∂p_WT/∂(roll, pitch, yaw)
  };

  /// As if nothing had been heard yet; the counters go on.
  void begin();
  void collect(const Inputs& inputs);
  void enqueue(Pending&& pending);
  /// Takes in what waits and is due: one measurement, and one more for every three that wait behind it.
  /// @returns whether there was any
  bool take_due(LabTime due);
  void process(const Pending& pending);
  void start(const Pending& pending);
  /// Puts the load where it was seen, as fast as any load may be.
  void place_load(const Vector3d& p_WL);
  void predict_to(LabTime t);
  void predict(double dt_s);
  void take(const topic::Mru& mru);
  void take_load(const topic::Bodies& load);
  void take_platform(const topic::Bodies& platform);
  bool update(Updates& updates, Reading kind, const math::SparseRow& row, double innovation, double sd);

  [[nodiscard]] ShipView view() const { return {filter_.x.data(), mount_.X_WN.p, R_WD_}; }
  [[nodiscard]] Vector3d triple(int derivative, int first_axis) const {
    return view().triple(derivative, first_axis);
  }
  [[nodiscard]] math::BodyMotion ship() const { return view().motion(); }
  [[nodiscard]] Tool tool(const math::BodyMotion& ship, const JointMotion& joints) const;
  [[nodiscard]] double hanging_height(const Vector2d& load, const Vector3d& p_WT) const;
  /// How strongly the wire pulls the load towards the tool, per distance [1/s²]: what holds it against
  /// gravity and the tool's acceleration, and what bends its path.
  [[nodiscard]] double stiffness(const Vector2d& load, const Vector2d& velocity,
                                 const math::PointMotion& tool) const;
  void add_tool_terms(math::SparseRow& row, const Tool& tool, const Vector3d& weight) const;
  void tell_second(topic::Estimate& out) const;
  [[nodiscard]] topic::Estimate estimate_at(LabTime t);
  void tell_deviations(topic::Estimate& out, const math::BodyMotion& ship, const Tool& tool) const;

  Belief belief_;
  MruMount mount_;
  SecondShip second_;
  ShipModel ship_model_;
  math::Matrix3d R_WD_;
  Filter filter_;
  LabTime now_{};  ///< time of the last step
  LabTime t_{};    ///< time of the filter's state
  bool started_ = false;

  ArmHistory arm_;
  double wire_length_m_ = 0;
  double wire_speed_mps_ = 0;
  LabTime wire_t_{};
  bool winch_heard_ = false;
  bool mru_heard_ = false;
  bool load_tracked_ = false;
  bool platform_tracked_ = false;
  LabTime platform_seen_{};
  LabTime load_seen_{};
  int load_refusals_ = 0;  ///< sightings of the load refused in a row

  std::uint64_t mru_seen_ = 0;
  std::uint64_t load_sequence_ = 0;
  std::uint64_t platform_sequence_ = 0;
  std::uint64_t arm_sequence_ = 0;
  std::uint64_t winch_sequence_ = 0;
  std::array<Pending, 32> pending_{};
  std::uint64_t refused_ = 0;
  std::array<Innovations, kReadings> innovations_{};
  std::uint64_t sequence_ = 0;
};

}  // namespace motionlab::estimator
