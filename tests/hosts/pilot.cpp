/// @file  Somebody's controller on a host of its own: commands by DDS until it owns the crane, turns the
/// first joint a little, says how, and lets go. The exit code says whether all of that happened.
///
///   hosts_pilot INTERFACE [peer=ADDRESS] [server=ADDRESS:PORT] [security=FOLDER]
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <string_view>
#include <thread>

#include "drivers/core/error.hpp"
#include "drivers/core/real_clock.hpp"
#include "gateway/bus/dds_bus.hpp"
#include "gateway/bus/local_bus.hpp"

namespace motionlab {
namespace {

constexpr Nanoseconds kPeriod = 5ms;
constexpr Nanoseconds kPatience = 40s;
constexpr Nanoseconds kPushFor = 1s;
constexpr double kPush_radps = 0.05;
constexpr double kMoved_rad = 0.02;
constexpr std::string_view kName = "pilot";

bus::DdsConfig connection(int argc, char** argv) {
  bus::DdsConfig config;
  config.participant = "pilot";
  if (argc > 1) config.interface_whitelist = {argv[1]};
  for (int i = 2; i < argc; ++i) {
    const std::string_view word = argv[i];
    const auto value = word.substr(word.find('=') + 1);
    if (word.starts_with("peer=")) config.peers.emplace_back(value);
    if (word.starts_with("server=")) config.server = value;
    if (word.starts_with("security=")) config.security = value;
  }
  return config;
}

class Pilot {
 public:
  explicit Pilot(const bus::DdsConfig& config) : dds_{config, local_} {
    dds_.out<topic::ArmCommand>();
    dds_.out<topic::ModeRequest>();
    dds_.in<topic::Mode>();
    dds_.in<topic::ArmState>();
    dds_.start();
  }
  ~Pilot() { dds_.stop(); }
  Pilot(const Pilot&) = delete;
  Pilot& operator=(const Pilot&) = delete;

  /// Commands until it is so. @returns false when it did not come about in time
  bool command(double qd_radps, const std::function<bool()>& done, Nanoseconds time = kPatience) {
    for (const LabTime end = clock_.now() + time; clock_.now() < end;) {
      if (done()) return true;
      topic::ArmCommand command;
      command.device = "arm";
      command.requester = kName;
      command.sequence_number = ++count_;
      command.t_created_ns = to_ns(clock_.now());
      command.follow = true;
      command.qd_wanted_radps[0] = qd_radps;
      commands_.publish(command);
      std::this_thread::sleep_for(kPeriod);
    }
    return false;
  }

  void ask(topic::ModeAction action) {
    topic::ModeRequest request;
    request.requester = kName;
    request.sequence_number = ++count_;
    request.t_created_ns = to_ns(clock_.now());
    request.action = action;
    request.external_controller = true;
    requests_.publish(request);
  }

  [[nodiscard]] topic::Mode mode() const { return modes_.newest().value_or(topic::Mode{}); }
  [[nodiscard]] double q_rad() const { return arms_.newest().value_or(topic::ArmState{}).q_rad[0]; }

 private:
  RealClock clock_;
  bus::LocalBus local_;
  bus::DdsBus dds_;
  bus::Publisher<topic::ArmCommand> commands_ = local_.advertise<topic::ArmCommand>();
  bus::Publisher<topic::ModeRequest> requests_ = local_.advertise<topic::ModeRequest>();
  bus::Reader<topic::Mode> modes_ = local_.reader<topic::Mode>();
  bus::Reader<topic::ArmState> arms_ = local_.reader<topic::ArmState>("arm");
  std::uint64_t count_ = 0;
};

enum class Flight { good, let_go, failed };

/// Takes the command, turns the first joint, settles.
Flight fly(Pilot& pilot) {
  const auto state = [&pilot] { return pilot.mode().state; };
  const auto fail = [&pilot](const char* what) {
    std::fprintf(stderr, "pilot: %s; the mode is %s: %s\n", what,
                 std::string{to_string(pilot.mode().state)}.c_str(), pilot.mode().reason.str().c_str());
    return pilot.mode().state == topic::ModeState::fault ? Flight::let_go : Flight::failed;
  };
  const auto ask_until = [&](topic::ModeAction action, const std::function<bool()>& done) {
    int round = 0;
    return pilot.command(0, [&] {
      if (round++ % 100 == 0) pilot.ask(action);
      return done();
    });
  };
  const auto is_ready = [&] { return state() == topic::ModeState::ready; };
  if (state() == topic::ModeState::fault) (void)ask_until(topic::ModeAction::reset, is_ready);
  if (!pilot.command(0, is_ready)) return fail("the gateway is not ready");
  const auto owns = [&] {
    return state() == topic::ModeState::engaged && pilot.mode().owner.view() == kName;
  };
  if (!ask_until(topic::ModeAction::engage, owns)) return fail("it does not own the crane");
  const double before = pilot.q_rad();
  if (pilot.command(
          kPush_radps, [&] { return !owns(); }, kPushFor))
    return fail("it was let go");
  const double turned = pilot.q_rad() - before;
  std::printf("pilot: owned the crane, turned joint 1 by %.4f rad\n", turned);
  if (std::abs(turned) < kMoved_rad) return fail("joint 1 did not turn");
  const auto is_over = [&] { return is_ready() || state() == topic::ModeState::settled; };
  return ask_until(topic::ModeAction::settle, is_over) ? Flight::good : fail("it does not settle");
}

/// A machine that stands still ends a lease, rightly: then once more, twice at most.
bool fly_patiently(Pilot& pilot) {
  Flight flight = Flight::let_go;
  for (int i = 0; i < 3 && flight == Flight::let_go; ++i) flight = fly(pilot);
  return flight == Flight::good;
}

}  // namespace
}  // namespace motionlab

int main(int argc, char** argv) {
  try {
    motionlab::Pilot pilot{motionlab::connection(argc, argv)};
    return motionlab::fly_patiently(pilot) ? 0 : 1;
  } catch (const motionlab::StartupError& error) {
    std::fprintf(stderr, "pilot: %s\n", error.what());
    return 2;
  }
}
