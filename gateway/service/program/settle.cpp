#include "gateway/service/program/settle.hpp"

#include <optional>
#include <string>

#include "drivers/core/error.hpp"
#include "drivers/core/real_clock.hpp"
#include "gateway/service/log/log.hpp"

namespace motionlab::service {

deadman::WireConfig wires(const GatewayConfig& config) {
  return {.listen = config.comau.listen,
          .arm = config.comau.driver,
          .robot_brakes_after_s = config.comau.watchdog_s,
          .plc = config.winch.plc,
          .winch = config.winch.driver};
}

int settle(const GatewayConfig& config) {
  const deadman::WireConfig where = wires(config);
  const RealClock clock;
  deadman::Settlement settlement(where, clock);
  try {
    settlement.open(where.listen);
  } catch (const StartupError& error) {
    throw StartupError(
        std::string(error.what()) +
        ". If a gateway of this configuration is running, settle it with: motionlab settle; if "
        "one has just died, its deadman is at work: try again in some seconds");
  }
  settlement.begin(std::nullopt);
  const deadman::Outcome outcome = settlement.finish();
  say(outcome.settled() ? LogLevel::info : LogLevel::error, "settle",
      outcome.settled() ? "settled" : "not_settled", outcome.text(where));
  return outcome.settled() ? 0 : 1;
}

}  // namespace motionlab::service
