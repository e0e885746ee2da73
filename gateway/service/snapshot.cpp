#include "gateway/service/snapshot.hpp"

namespace motionlab::service {

Snapshots::Snapshots(const GatewayConfig& config, bus::LocalBus& local)
    : mru_{local.reader<topic::Mru>(config.mrus.front().driver.device), {}},
      load_{local.reader<topic::Bodies>(config.qualisys.driver.device, config.qualisys.load_body), {}},
      platform_{local.reader<topic::Bodies>(config.qualisys.driver.device, config.qualisys.platform_body),
                {}},
      arm_{local.reader<topic::ArmState>(config.comau.driver.device), {}},
      winch_{local.reader<topic::WinchState>(config.winch.driver.device), {}},
      second_mru_{local.reader<topic::Mru>(config.mrus.back().driver.device), {}},
      local_{local},
      arm_name_{config.comau.driver.device},
      winch_name_{config.winch.driver.device} {}

Snapshot Snapshots::at(LabTime t, const Text<32>& controller) {
  Snapshot now{t,
               mru_.newest(),
               load_.newest(),
               platform_.newest(),
               arm_.newest(),
               winch_.newest(),
               second_mru_.newest(),
               {},
               {}};
  if (!controller.empty()) {
    now.external_arm = local_.newest<topic::ArmCommand>(arm_name_, controller);
    now.external_winch = local_.newest<topic::WinchCommand>(winch_name_, controller);
  }
  return now;
}

}  // namespace motionlab::service
