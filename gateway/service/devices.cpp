#include "gateway/service/devices.hpp"

#include <algorithm>
#include <optional>

#include "gateway/service/snapshot.hpp"

namespace motionlab::service {
namespace {

constexpr Nanoseconds kHealthPeriod = 100ms;

/// The device's link as it is published. `stale` follows from the age and the limit in force.
topic::Health health_topic(const std::string& device, const LinkHealth& link, const LinkRule& rule,
                           LabTime now, double clock_offset_s, double clock_drift_ppm) {
  topic::Health health;
  health.device = device;
  health.t_ns = to_ns(now);
  health.required = rule.required;
  health.rate_hz = link.rate_hz(now);
  health.age_s = link.t_measured() ? seconds(now - *link.t_measured()) : -1.0;
  health.age_max_s = seconds(link.age_max());
  health.stale_after_s = rule.stale_after_s;
  health.received = link.received();
  health.lost = link.lost();
  health.reconnects = link.reconnects();
  for (std::size_t i = 0; i < kReasonCount; ++i) health.rejected[i] = link.rejected(static_cast<Reason>(i));
  health.clock_offset_s = clock_offset_s;
  health.clock_drift_ppm = clock_drift_ppm;
  health.advice = link.advice();
  const bool stale = link.t_received() && seconds(now - *link.t_received()) > rule.stale_after_s;
  switch (link.phase()) {
    case LinkPhase::down:
      health.link = topic::LinkState::down;
      break;
    case LinkPhase::connecting:
      health.link = topic::LinkState::connecting;
      break;
    case LinkPhase::up:
      health.link = stale ? topic::LinkState::stale : topic::LinkState::up;
      break;
  }
  return health;
}

}  // namespace

struct Devices::Impl {
  /// One MRU with its socket.
  struct MruEnd {
    MruEnd(const MruLink& link, Network& network, Sink<topic::Mru> sink)
        : config(link), driver(link.driver, std::move(sink)), socket(network.datagram(link.listen)) {
      socket->on_datagram(
          [this](Bytes bytes, Endpoint from, LabTime t) { driver.on_datagram(bytes, from, t); });
    }
    MruLink config;
    mru::MruDriver driver;
    std::unique_ptr<DatagramSocket> socket;
  };

  /// The PLC's remote reply with its socket.
  struct PlcReplyEnd {
    PlcReplyEnd(const PlcReplyLink& link, Network& network, Sink<topic::Bodies> on_body,
                Sink<topic::Mru> on_mru)
        : config(link),
          socket(network.datagram(link.listen)),
          driver(link.driver, *socket, std::move(on_body), std::move(on_mru)) {
      socket->on_datagram(
          [this](Bytes bytes, Endpoint from, LabTime t) { driver.on_datagram(bytes, from, t); });
    }
    PlcReplyLink config;
    std::unique_ptr<DatagramSocket> socket;
    plc_reply::PlcReplyDriver driver;
  };

  Impl(const GatewayConfig& c, Network& network, bus::LocalBus& local, ArmSchedule& arm_schedule,
       Sink<topic::ArmCommand> on_arm_sent_in)
      : config(c),
        schedule(arm_schedule),
        on_arm_sent(std::move(on_arm_sent_in)),
        publish_mru(local.advertise<topic::Mru>()),
        publish_bodies(local.advertise<topic::Bodies>()),
        publish_arm(local.advertise<topic::ArmState>()),
        publish_winch(local.advertise<topic::WinchState>()),
        publish_health(local.advertise<topic::Health>()),
        arm_commands(local.reader<topic::ArmCommand>(c.comau.driver.device, kGatewayRequester)),
        winch_commands(local.reader<topic::WinchCommand>(c.winch.driver.device, kGatewayRequester)),
        comau_socket(network.datagram(c.comau.listen)),
        arm(
            c.comau.driver, *comau_socket, [this](const topic::ArmState& s) { publish_arm.publish(s); },
            [this](const topic::ArmCommand& sent) {
              if (on_arm_sent) on_arm_sent(sent);
              // A full queue means that control stands still; what it misses shows up in the encoders.
              (void)schedule.sent.push(sent);
            }),
        qualisys_stream(network.client(c.qualisys.server)),
        qualisys_socket(network.datagram(c.qualisys.listen)),
        cameras(c.qualisys.driver, *qualisys_stream,
                [this](const topic::Bodies& b) { publish_bodies.publish(b); }),
        winch_stream(network.client(c.winch.plc)),
        winch(c.winch.driver, *winch_stream,
              [this](const topic::WinchState& s) { publish_winch.publish(s); }) {
    for (const auto& link : c.mrus) {
      mrus.push_back(
          std::make_unique<MruEnd>(link, network, [this](const topic::Mru& m) { publish_mru.publish(m); }));
    }
    if (c.plc_reply) {
      plc_reply.emplace(
          *c.plc_reply, network, [this](const topic::Bodies& b) { publish_bodies.publish(b); },
          [this](const topic::Mru& m) { publish_mru.publish(m); });
    }
    comau_socket->on_datagram(
        [this](Bytes bytes, Endpoint from, LabTime t) { arm.on_datagram(bytes, from, t); });
    qualisys_socket->on_datagram(
        [this](Bytes bytes, Endpoint from, LabTime t) { cameras.on_datagram(bytes, from, t); });
    qualisys_stream->on_event(&cameras);
    winch_stream->on_event(&winch);
  }

  void publish_all_health(LabTime now) {
    const auto publish = [&](const std::string& device, const LinkHealth& link, const LinkRule& rule,
                             double offset_s, double drift_ppm) {
      topic::Health health = health_topic(device, link, rule, now, offset_s, drift_ppm);
      health.sequence_number = health_sequence;
      publish_health.publish(health);
    };
    ++health_sequence;
    for (const auto& mru : mrus) {
      publish(mru->config.driver.device, mru->driver.health(), mru->config.rule, mru->driver.clock_offset_s(),
              mru->driver.clock_drift_ppm());
    }
    publish(config.qualisys.driver.device, cameras.health(), config.qualisys.rule, cameras.clock().offset_s(),
            cameras.clock().drift_ppm());
    publish(config.comau.driver.device, arm.health(), config.comau.rule, arm.clock_offset_s(),
            arm.clock_drift_ppm());
    publish(config.winch.driver.device, winch.health(), config.winch.rule, winch.clock().offset_s(),
            winch.clock().drift_ppm());
    if (plc_reply) {
      // It has no clock that could be followed.
      publish(plc_reply->config.driver.device, plc_reply->driver.health(), plc_reply->config.rule, 0.0, 0.0);
    }
  }

  GatewayConfig config;
  ArmSchedule& schedule;
  Sink<topic::ArmCommand> on_arm_sent;
  bus::Publisher<topic::Mru> publish_mru;
  bus::Publisher<topic::Bodies> publish_bodies;
  bus::Publisher<topic::ArmState> publish_arm;
  bus::Publisher<topic::WinchState> publish_winch;
  bus::Publisher<topic::Health> publish_health;
  bus::Reader<topic::ArmCommand> arm_commands;
  bus::Reader<topic::WinchCommand> winch_commands;

  std::vector<std::unique_ptr<MruEnd>> mrus;
  std::unique_ptr<DatagramSocket> comau_socket;
  comau::ComauDriver arm;
  std::unique_ptr<StreamClient> qualisys_stream;
  std::unique_ptr<DatagramSocket> qualisys_socket;
  qualisys::QualisysDriver cameras;
  std::unique_ptr<StreamClient> winch_stream;
  winch::WinchDriver winch;
  std::optional<PlcReplyEnd> plc_reply;

  LabTime next_health = LabTime::min();
  std::uint64_t health_sequence = 0;
};

Devices::Devices(const GatewayConfig& config, Network& network, bus::LocalBus& local, ArmSchedule& schedule,
                 Sink<topic::ArmCommand> on_arm_sent)
    : impl_(std::make_unique<Impl>(config, network, local, schedule, std::move(on_arm_sent))) {}

Devices::~Devices() = default;

void Devices::step(LabTime now) {
  Impl& d = *impl_;
  if (const auto command = d.arm_commands.newer()) d.arm.set_command(*command);
  // What the winch refuses it counts itself; the last good command then grows stale and the winch stops.
  if (const auto command = d.winch_commands.newer()) (void)d.winch.set_command(*command);
  for (const auto& mru : d.mrus) mru->driver.step(now);
  d.cameras.step(now);
  d.arm.step(now);
  d.winch.step(now);
  if (d.plc_reply) d.plc_reply->driver.step(now);
  d.schedule.t_next_send_ns.store(to_ns(d.arm.next_send()), std::memory_order_relaxed);
  if (now >= d.next_health) {
    d.publish_all_health(now);
    d.next_health = now + kHealthPeriod;
  }
}

LabTime Devices::next_send() const {
  return impl_->arm.next_send();
}

void Devices::orderly_stop() {
  impl_->arm.orderly_stop();
  impl_->winch.orderly_stop();
}

bool Devices::stopped() const {
  return impl_->arm.stopped() && impl_->winch.stopped();
}

}  // namespace motionlab::service
