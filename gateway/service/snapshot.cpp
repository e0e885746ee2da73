#include "gateway/service/snapshot.hpp"

namespace motionlab::service {
namespace {

template <class T>
void take_newer(bus::Reader<T>& reader, Sequence<T, 1>& into) {
  into.clear();
  if (const auto sample = reader.newer()) into.push(*sample);
}

/// As many as there is room for; the others wait for the next step.
template <class T, std::size_t N, class Next>
void take_all(Sequence<T, N>& into, Next&& next) {
  into.clear();
  while (!into.full()) {
    const std::optional<T> item = next();
    if (!item) return;
    into.push(*item);
  }
}

template <class T>
void keep_newest(const Sequence<T, 1>& from, std::optional<T>& into) {
  if (!from.empty()) into = from.back();
}

}  // namespace

Inputs::Inputs(const GatewayConfig& config, bus::LocalBus& local, ArmSchedule& schedule)
    : mru_(local.reader<topic::Mru>(config.mrus.front().driver.device)),
      load_(local.reader<topic::Bodies>(config.qualisys.driver.device, config.qualisys.load_body)),
      platform_(local.reader<topic::Bodies>(config.qualisys.driver.device, config.qualisys.platform_body)),
      arm_(local.reader<topic::ArmState>(config.comau.driver.device)),
      winch_(local.reader<topic::WinchState>(config.winch.driver.device)),
      second_mru_(local.reader<topic::Mru>(config.mrus.back().driver.device)),
      requests_(local.subscribe<topic::ModeRequest>()),
      references_(local.subscribe<topic::Reference>()),
      schedule_(schedule),
      local_(local),
      arm_name_(config.comau.driver.device),
      winch_name_(config.winch.driver.device) {}

topic::Snapshot& Inputs::gather(LabTime t) {
  ++inputs_.sequence_number;
  inputs_.t_ns = to_ns(t);
  inputs_.t_next_send_ns = schedule_.t_next_send_ns.load(std::memory_order_relaxed);
  inputs_.deadman_lost = schedule_.deadman_lost.load(std::memory_order_relaxed);
  take_all(inputs_.requests, [this] { return requests_.next(); });
  take_all(inputs_.references, [this] { return references_.next(); });
  take_all(inputs_.sent, [this] { return schedule_.sent.pop(); });
  take_newer(mru_, inputs_.mru);
  take_newer(load_, inputs_.load);
  take_newer(platform_, inputs_.platform);
  take_newer(arm_, inputs_.arm);
  take_newer(winch_, inputs_.winch);
  take_newer(second_mru_, inputs_.second_mru);
  return inputs_;
}

void Inputs::gather_commands_of(const Text<32>& controller) {
  inputs_.external_arm.clear();
  inputs_.external_winch.clear();
  if (controller.empty()) return;
  if (const auto arm = local_.newest<topic::ArmCommand>(arm_name_, controller))
    inputs_.external_arm.push(*arm);
  if (const auto winch = local_.newest<topic::WinchCommand>(winch_name_, controller))
    inputs_.external_winch.push(*winch);
}

const Snapshot& Newest::take(const topic::Snapshot& inputs) {
  now_.t = from_ns(inputs.t_ns);
  now_.deadman_lost = inputs.deadman_lost;
  now_.t_next_send = from_ns(inputs.t_next_send_ns);
  keep_newest(inputs.mru, now_.mru);
  keep_newest(inputs.load, now_.load);
  keep_newest(inputs.platform, now_.platform);
  keep_newest(inputs.arm, now_.arm);
  keep_newest(inputs.winch, now_.winch);
  keep_newest(inputs.second_mru, now_.second_mru);
  now_.external_arm.reset();
  now_.external_winch.reset();
  keep_newest(inputs.external_arm, now_.external_arm);
  keep_newest(inputs.external_winch, now_.external_winch);
  return now_;
}

}  // namespace motionlab::service
