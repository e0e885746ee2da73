/// @file  Our end of a Qualisys camera system: a client of QTM's real-time protocol 1.25 … 1.21.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/core/device_clock.hpp"
#include "drivers/core/endpoint.hpp"
#include "drivers/core/link_health.hpp"
#include "drivers/core/network.hpp"
#include "drivers/core/sink.hpp"
#include "drivers/core/time.hpp"
#include "drivers/qualisys/qualisys_driver_hook.hpp"
#include "drivers/qualisys/qualisys_driver_order.hpp"
#include "drivers/qualisys/qualisys_driver_orientation.hpp"
#include "drivers/qualisys/qualisys_wire.hpp"
#include "drivers/qualisys/qualisys_wire_data.hpp"
#include "drivers/qualisys/qualisys_wire_xml.hpp"
#include "idl/bodies.hpp"

namespace motionlab::qualisys {

struct DriverConfig {
  std::string device = "qualisys";          ///< name on the topics
  std::vector<std::string> bodies{"load"};  ///< names in QTM, in any case of letters
  HookConfig hook;                          ///< a body that QTM does not know: two markers without labels
  std::endian byte_order = std::endian::little;  ///< of the server's port: base + 1 is little, base + 2 big
  std::uint32_t server_address = 0;  ///< datagrams are taken from here only; 0: from anywhere (tests)
  std::uint16_t udp_port = 0;        ///< our bound port, where QTM shall send; 0: stream over TCP
  double latency_s = 0.007;          ///< exposure to arrival, published figure for Oqus cameras
  double frame_period_s = 0.005;     ///< nominal, of the real-time stream
  double stale_after_periods = 5.0;  ///< without a frame for so long the bodies are lost
  double probe_after_s = 1.0;        ///< without a frame for so long the server is asked for its state
  double reply_timeout_s = 2.0;      ///< for a connection, and for each answer
  double backoff_min_s = 0.5;        ///< from a failure to the next attempt; doubles …
  double backoff_max_s = 5.0;        ///< … up to this, until an attempt gets the list of bodies
};

/// Connects to QTM, asks for its rigid bodies and tells every frame of the wanted ones.
///
/// Speaks the newest protocol that both know, from 1.25 down to 1.21; before that, bodies are described
/// otherwise, and it fails and says so.
///
/// One `topic::Bodies` sample per wanted body (and hook) and frame, also while it is lost or unknown to QTM
/// (`tracked` false, pose zero). When frames stop coming (stale, measurement stopped, connection lost, list
/// of bodies changed), one more sample per body says `tracked` false, measured one period after the last
/// frame: no reader keeps a pose. Before the first frame nothing is told.
///
/// `t_measured_ns` is the exposure: QTM's time stamp (or the camera time, when QTM sends it) mapped through a
/// `DeviceClock` with the configured latency. A time stamp that starts again is believed once two frames in a
/// row say so; until then a frame older than the last is late, and dropped.
///
/// Once per connection and change of settings it asks for one frame with the angles of the bodies too, and
/// compares (`OrientationCheck`); what does not agree stands in the advice.
///
/// QTM is never controlled: measurements are started and stopped by people. Its end of a measurement is not a
/// fault: the link stays up, the advice says what is missing.
///
/// Feed it with the stream's events, the datagrams of the UDP port and `step` about every millisecond.
/// Nothing throws after construction.
class QualisysDriver final : public StreamEvents {
 public:
  /// How far the conversation has come.
  enum class State : std::uint8_t {
    down,         ///< no connection; the next attempt waits
    connecting,   ///< waits for the connection
    welcome,      ///< waits for the server's greeting
    version,      ///< waits for the answer to a version: 1.25 first, an older one after each refusal
    qtm_version,  ///< waits for the version of QTM
    get_state,    ///< waits for the event that tells the state
    bodies,       ///< waits for the list of bodies
    streaming,    ///< frames come, or should
    idle,         ///< QTM does not measure; asked again now and then
  };

  /// @param control  the TCP connection to QTM's port of the configured byte order
  QualisysDriver(DriverConfig config, StreamOut& control, Sink<topic::Bodies> sink);

  void on_open(LabTime t) override;
  void on_bytes(Bytes bytes, LabTime t_received) override;
  void on_closed(std::string_view why, LabTime t) override;
  /// One datagram of the stream's UDP port.
  void on_datagram(Bytes datagram, Endpoint from, LabTime t_received);
  /// Watches the time: attempts, time-outs, stale data.
  void step(LabTime now);

  [[nodiscard]] const LinkHealth& health() const noexcept { return health_; }
  [[nodiscard]] State state() const noexcept { return state_; }
  /// What the server calls itself, for the log; empty before it was asked.
  [[nodiscard]] std::string_view qtm_version() const noexcept { return qtm_version_; }
  /// The protocol 1.n that is spoken, or tried.
  [[nodiscard]] int version_minor() const noexcept { return version_minor_; }
  [[nodiscard]] OrientationCheck::Verdict orientation() const noexcept { return orientation_.verdict(); }
  /// Laboratory time minus device time, for `motionlab/health`.
  [[nodiscard]] const DeviceClock& clock() const noexcept { return clock_; }

 private:
  /// One body that somebody wants, and where it stands in QTM's list.
  struct Wanted {
    std::string name;
    std::string missing_advice;  ///< kept for the driver's life: the health only looks at it
    std::string disabled_advice;
    std::optional<std::size_t> index;
    bool enabled = true;
    std::uint64_t sequence_number = 0;
  };

  /// What a sample repeats of its frame.
  struct FrameHead {
    std::uint32_t frame_number = 0;
    double drop_rate = 0.0;
    double out_of_sync_rate = 0.0;
  };

  void connect(LabTime now);
  void fail(Fault fault, LabTime now);
  void enter(State state, LabTime now) noexcept;
  void command(std::string_view text, LabTime now);
  void ask_version(LabTime now);
  void on_version(PacketType type, std::string_view text, LabTime t);
  void probe(LabTime now);
  void read_bodies(bool restream, LabTime now);
  void begin_measurement(LabTime now);

  void on_packet(const Packet& packet, LabTime t);
  void on_text(PacketType type, std::string_view text, LabTime t);
  void on_event(Event event, LabTime t);
  void on_no_more_data(LabTime t);
  void on_body_list(std::string_view xml, LabTime t);
  void on_frame(Bytes payload, LabTime t_received);
  void on_checked_frame(Bytes payload);

  void on_wrong_count(LabTime now);
  void begin_frame(const DataFrame& packet, const FrameOrder::Verdict& verdict, LabTime t_received);
  void stamp(const DataFrame& packet, LabTime t_received);
  void tell_bodies(const DataFrame& packet, LabTime t_received);
  void tell_hook(const DataFrame& packet, LabTime t_received);
  void tell(Wanted& body, const BodyPose& pose, LabTime t_measured, LabTime t_received);
  void lose_all(LabTime now);
  void forget_time() noexcept;
  void advise() noexcept;

  DriverConfig config_;
  StreamOut& control_;
  Sink<topic::Bodies> sink_;
  LinkHealth health_;
  PacketSplitter splitter_;
  DeviceClock clock_;
  std::string stream_command_;
  std::string qtm_version_;

  int version_minor_;

  State state_ = State::down;
  LabTime t_state_{};                 ///< when the state was entered
  LabTime t_bytes_{};                 ///< when the connection last gave bytes
  std::optional<LabTime> t_attempt_;  ///< when to connect again; at once when empty
  double backoff_s_;
  bool was_connected_ = false;

  std::optional<Event> event_;  ///< the newest that tells whether QTM measures
  bool measuring_ = false;
  LabTime t_probe_{};
  bool probing_ = false;        ///< GetState was sent, its answer has not come
  bool restream_ = false;       ///< ask for the stream again once the list is read
  bool list_outdated_ = false;  ///< it changed while it was being read
  LabTime t_list_{};            ///< when the list was last asked for

  std::vector<BodyDefinition> list_;
  std::vector<Wanted> wanted_;
  bool list_refused_ = false;
  bool wrong_count_ = false;  ///< frames hold another number of bodies than the list
  bool silent_ = false;       ///< QTM measures, but no frames come

  FrameOrder order_;
  OrientationCheck orientation_;
  Wanted hook_;
  MarkerPair pair_;
  LabTime t_frame_{};           ///< when a frame last came, or was first expected
  bool showing_ = false;        ///< readers may hold a pose from us
  bool hook_showing_ = false;   ///< likewise of the hook
  bool hook_in_frame_ = false;  ///< the newest frame brought markers
  FrameHead head_;              ///< of the newest frame
  bool stamped_ = false;        ///< the newest frame has a measured time
  LabTime t_measured_{};        ///< exposure of the newest frame
  bool has_camera_time_ = false;
};

}  // namespace motionlab::qualisys
