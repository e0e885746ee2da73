#include <algorithm>

#include "simulators/winch/winch_device.hpp"

namespace motionlab::winch {

namespace {
constexpr std::size_t kSubscriptionsMax = 550;  // the vendor's limit per device
}  // namespace

AddNotificationResponse WinchDevice::subscribe(const AmsHeader& header,
                                               const AddNotificationRequest& request) {
  const Place found = place(header.target, request.index_group, request.index_offset);
  if (found.error != ads_error::none) return {found.error, 0};
  const auto mode = static_cast<NotificationMode>(request.mode);
  if (mode != NotificationMode::cyclic && mode != NotificationMode::on_change) {
    return {ads_error::invalid_data, 0};
  }
  if (request.length == 0 || request.length > found.bytes.size()) return {ads_error::invalid_size, 0};
  if (subscriptions_.size() >= kSubscriptionsMax) return {ads_error::no_more_handles, 0};
  Subscription subscription;
  subscription.handle = next_subscription_++;
  subscription.server = header.target;
  subscription.client = header.source;
  subscription.item = {request.index_group, request.index_offset, request.length};
  subscription.mode = mode;
  subscription.period = std::max(request.cycle_time, from_seconds(config_.plc.task_period_s));
  subscription.due = now_ + subscription.period;
  subscriptions_.push_back(std::move(subscription));
  return {ads_error::none, subscriptions_.back().handle};
}

std::uint32_t WinchDevice::unsubscribe(const AmsAddress& client, std::uint32_t handle) {
  const bool removed = std::erase_if(subscriptions_, [&](const Subscription& s) {
                         return s.handle == handle && s.client == client;
                       }) > 0;
  return removed ? ads_error::none : ads_error::notification_handle_invalid;
}

void WinchDevice::send_first_samples() {
  for (auto& subscription : subscriptions_) {
    if (!subscription.sent.empty()) continue;
    const Place found =
        place(subscription.server, subscription.item.index_group, subscription.item.index_offset);
    if (found.bytes.size() < subscription.item.length) continue;
    send_sample(subscription, found.bytes.first(subscription.item.length));
  }
}

void WinchDevice::notify(LabTime t) {
  const double slow_by = faults_.common.slow_by();
  for (auto& subscription : subscriptions_) {
    const bool of_task = subscription.item.index_group != index_group::device_data &&
                         subscription.item.index_group != index_group::symbol_version &&
                         subscription.server.port != ams_port::system_service;
    if ((of_task && state_ != AdsState::run) || t < subscription.due) continue;
    const Place found =
        place(subscription.server, subscription.item.index_group, subscription.item.index_offset);
    if (found.error != ads_error::none || found.bytes.size() < subscription.item.length) continue;
    const Bytes value = found.bytes.first(subscription.item.length);
    if (subscription.mode == NotificationMode::on_change &&
        std::equal(value.begin(), value.end(), subscription.sent.begin(), subscription.sent.end())) {
      continue;
    }
    const auto period = from_seconds(slow_by * seconds(subscription.period));
    subscription.due += period;
    if (subscription.due <= t) subscription.due = t + period;
    send_sample(subscription, value);
  }
}

void WinchDevice::send_sample(Subscription& subscription, Bytes value) {
  subscription.sent.assign(value.begin(), value.end());
  const auto client = std::find_if(clients_.begin(), clients_.end(),
                                   [&](const Client& c) { return c.address == subscription.client; });
  Session* session = client == clients_.end() ? nullptr : find(client->session);
  if (session == nullptr) return;
  const NotificationSample sample{subscription.handle, subscription.sent};
  const NotificationStamp stamp{to_filetime(plc_.clock(now_)), {&sample, 1}};
  const AmsHeader header{subscription.client,
                         subscription.server,
                         static_cast<std::uint16_t>(AdsCommand::notification),
                         kRequestFlags,
                         0,
                         0};
  if (const auto frame = encode_frame(frame_, header, NotificationStream{{&stamp, 1}})) {
    transmit(*session, *frame);
  }
}

}  // namespace motionlab::winch
