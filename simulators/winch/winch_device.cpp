#include "simulators/winch/winch_device.hpp"

#include <algorithm>

namespace motionlab::winch {

namespace {

constexpr std::size_t kAnswerMax = 64 * 1024;
constexpr std::size_t kHandlesMax = 4096;
constexpr std::size_t kSubscriptionsMax = 550;  // the vendor's limit per device
constexpr std::size_t kClientsMax = 256;
constexpr std::uint32_t kSymbolFlags = 0x8;  // has a type name
constexpr DeviceInfoResponse kPlcInfo{0, 3, 1, 4022, "Plc30 App"};
constexpr DeviceInfoResponse kSystemInfo{0, 3, 1, 4022, "TwinCAT System"};

constexpr Fault kUnknownFault{
    Reason::bad_value,
    "unknown fault; the winch knows silent, late, drop_route, stop_plc, frozen_cycle, "
    "drive_fault, close_mid_frame, half_frames, outlier_100ms"};

}  // namespace

WinchDevice::WinchDevice(DeviceConfig config, ServerOut& out)
    : config_(std::move(config)),
      out_(out),
      plc_(config_.plc),
      data_(kAnswerMax),
      frame_(kAnswerMax + kFrameHeaderSize + 64) {
  add_symbols("GVL_Winch.stCommand", kCommandType, command_members(), PlcProgram::kCommandAt, kCommandSize);
  add_symbols("GVL_Winch.stStatus", kStatusType, status_members(), PlcProgram::kStatusAt, kStatusSize);
}

void WinchDevice::add_symbols(std::string_view name, std::string_view type, std::span<const Member> members,
                              std::uint32_t offset, std::uint32_t size) {
  symbols_.push_back({std::string{name}, type, DataType::structure, offset, size});
  for (const auto& member : members) {
    symbols_.push_back({std::string{name} + "." + std::string{member.name}, member.type, member.data_type,
                        offset + member.offset, member.size});
  }
}

const WinchDevice::Symbol* WinchDevice::symbol(std::string_view name) const {
  const auto found = std::find_if(symbols_.begin(), symbols_.end(),
                                  [&](const Symbol& s) { return same_name(s.name, name); });
  return found == symbols_.end() ? nullptr : &*found;
}

// Sessions

WinchDevice::Session* WinchDevice::find(SessionId id) {
  const auto found =
      std::find_if(sessions_.begin(), sessions_.end(), [&](const Session& s) { return s.id == id; });
  return found == sessions_.end() ? nullptr : &*found;
}

void WinchDevice::drop(SessionId id) {
  out_.close(id);
  std::erase_if(sessions_, [&](const Session& s) { return s.id == id; });
}

void WinchDevice::on_accepted(SessionId id, Endpoint from, LabTime t) {
  now_ = t;
  if (config_.one_connection_per_address) {
    const auto older = std::find_if(sessions_.begin(), sessions_.end(),
                                    [&](const Session& s) { return s.from.address == from.address; });
    if (older != sessions_.end()) drop(older->id);
  }
  sessions_.push_back({id, from});
}

void WinchDevice::on_closed(SessionId id, LabTime t) {
  now_ = t;
  std::erase_if(sessions_, [&](const Session& s) { return s.id == id; });
}

void WinchDevice::on_bytes(SessionId id, Bytes bytes, LabTime t_received) {
  now_ = t_received;
  Session* session = find(id);
  if (session == nullptr) return;
  session->splitter.append(bytes);
  while ((session = find(id)) != nullptr) {  // serving a frame may have closed the session
    const auto next = session->splitter.next();
    if (!next) {
      ++malformed_;
      drop(id);
      return;
    }
    if (!*next) return;
    const TcpFrame frame = **next;
    if (faults_.drop_route) {
      drop(id);
    } else if (frame.command != TcpCommand::ads) {
      serve_local(*session, frame);
    } else if (const auto ams = decode_ams(frame.body)) {
      serve(*session, *ams);
    } else {
      ++malformed_;
      drop(id);
    }
  }
}

void WinchDevice::serve_local(Session& session, const TcpFrame& frame) {
  if (frame.command != TcpCommand::port_connect && frame.command != TcpCommand::port_close) return;
  if (frame.body.size() != sizeof(std::uint16_t)) {
    ++malformed_;
    return;
  }
  const auto wanted = load<std::uint16_t, std::endian::little>(frame.body);
  if (frame.command == TcpCommand::port_close) {  // the answer of a router is to close the connection
    const AmsAddress closed{config_.net_id, wanted};
    std::erase_if(subscriptions_, [&](const Subscription& s) { return s.client == closed; });
    drop(session.id);
    return;
  }
  LittleWriter body{data_};
  body.write_bytes(config_.net_id.numbers);
  body.write(wanted != 0 ? wanted : next_port_++);
  if (const auto reply = encode_tcp_frame(frame_, TcpCommand::port_connect, body.written())) {
    transmit(session, *reply);
  }
}

bool WinchDevice::has_route(const NetId& source) const {
  return config_.routes.empty() || source == config_.net_id ||
         std::find(config_.routes.begin(), config_.routes.end(), source) != config_.routes.end();
}

std::uint32_t WinchDevice::routing_error(const AmsAddress& target) const {
  if (target.net_id != config_.net_id) return ads_error::machine_not_found;
  if (target.port == ams_port::system_service) return ads_error::none;
  const bool there = target.port == config_.plc_port && state_ != AdsState::config;
  return there ? ads_error::none : ads_error::port_not_found;
}

void WinchDevice::remember(const AmsAddress& client, SessionId session) {
  const auto known =
      std::find_if(clients_.begin(), clients_.end(), [&](const Client& c) { return c.address == client; });
  if (known != clients_.end()) {
    known->session = session;
    return;
  }
  if (clients_.size() >= kClientsMax) clients_.erase(clients_.begin());
  clients_.push_back({client, session});
}

// Requests

void WinchDevice::serve(Session& session, const AmsFrame& frame) {
  const AmsHeader& header = frame.header;
  if (!has_route(header.source.net_id)) {
    drop(session.id);
    return;
  }
  if (header.is_response()) {
    ++malformed_;
    return;
  }
  remember(header.source, session.id);
  if (const auto error = routing_error(header.target)) {
    answer(session, header, NoData{}, error);
    return;
  }
  switch (static_cast<AdsCommand>(header.command)) {
    case AdsCommand::read_device_info:
      serve_info(session, frame);
      return;
    case AdsCommand::read:
      serve_read(session, frame);
      return;
    case AdsCommand::write:
      serve_write(session, frame);
      return;
    case AdsCommand::read_state:
      serve_state(session, frame);
      return;
    case AdsCommand::write_control:
      serve_control(session, frame);
      return;
    case AdsCommand::add_notification:
      serve_subscribe(session, frame);
      return;
    case AdsCommand::delete_notification:
      serve_unsubscribe(session, frame);
      return;
    case AdsCommand::read_write:
      serve_read_write(session, frame);
      return;
    case AdsCommand::notification:
      break;
  }
  answer(session, header, ResultResponse{ads_error::service_not_supported});
}

void WinchDevice::serve_state(Session& session, const AmsFrame& frame) {
  const bool system = frame.header.target.port == ams_port::system_service;
  const AdsState state = system && state_ == AdsState::stop ? AdsState::run : state_;
  answer(session, frame.header, ReadStateResponse{0, state, 0});
}

void WinchDevice::serve_info(Session& session, const AmsFrame& frame) {
  const bool system = frame.header.target.port == ams_port::system_service;
  answer(session, frame.header, system ? kSystemInfo : kPlcInfo);
}

void WinchDevice::serve_read(Session& session, const AmsFrame& frame) {
  const auto request = ReadRequest::decode(frame.data);
  if (!request) {
    ++malformed_;
    answer(session, frame.header, ReadResponse{ads_error::invalid_size, {}});
    return;
  }
  const Place found = place(frame.header.target, request->index_group, request->index_offset);
  const std::size_t length = std::min<std::size_t>(request->length, found.bytes.size());
  answer(session, frame.header, ReadResponse{found.error, found.bytes.first(length)});
}

void WinchDevice::serve_write(Session& session, const AmsFrame& frame) {
  const auto request = WriteRequest::decode(frame.data);
  std::uint32_t result = ads_error::invalid_size;
  if (request) {
    result = write_value(frame.header.target, request->index_group, request->index_offset, request->data);
  } else {
    ++malformed_;
  }
  answer(session, frame.header, ResultResponse{result});
}

void WinchDevice::serve_read_write(Session& session, const AmsFrame& frame) {
  const auto request = ReadWriteRequest::decode(frame.data);
  if (!request) {
    ++malformed_;
    answer(session, frame.header, ReadResponse{ads_error::invalid_size, {}});
    return;
  }
  const AmsAddress& server = frame.header.target;
  LittleWriter data{data_};
  std::uint32_t result = ads_error::none;
  if (server.port == ams_port::system_service) {
    result = ads_error::invalid_index_group;
  } else if (request->index_group == index_group::sum_read) {
    result = sum_read(server, *request, data);
  } else if (request->index_group == index_group::sum_write) {
    result = sum_write(server, *request, data);
  } else {
    result = read_by_name(*request, data);
  }
  if (result == ads_error::none && (!data.ok() || data.position() > request->read_length)) {
    result = ads_error::invalid_size;
  }
  answer(session, frame.header, ReadResponse{result, result == ads_error::none ? data.written() : Bytes{}});
}

std::uint32_t WinchDevice::read_by_name(const ReadWriteRequest& request, LittleWriter& data) {
  const bool by_name = request.index_group == index_group::handle_by_name ||
                       request.index_group == index_group::info_by_name ||
                       request.index_group == index_group::info_by_name_ex;
  if (!by_name) return ads_error::invalid_index_group;
  const Symbol* found = symbol(symbol_name(request.data));
  if (found == nullptr) return ads_error::symbol_not_found;
  const SymbolPlace where{index_group::plc_data, found->offset, found->size};
  if (request.index_group == index_group::info_by_name) {
    where.encode(data);
    return ads_error::none;
  }
  if (request.index_group == index_group::info_by_name_ex) {
    SymbolEntry{where, found->data_type, kSymbolFlags, found->name, found->type, {}}.encode(data);
    return ads_error::none;
  }
  if (handles_.size() >= kHandlesMax) return ads_error::no_more_handles;
  if (request.read_length < sizeof(std::uint32_t)) return ads_error::invalid_size;
  const Handle handle{next_handle_++, static_cast<std::uint32_t>(found - symbols_.data())};
  handles_.push_back(handle);
  if (request.read_length == sizeof(std::uint32_t)) {
    data.write(handle.id);
  } else {
    LongHandle{handle.id, found->size, 0, found->type}.encode(data);
  }
  return ads_error::none;
}

std::uint32_t WinchDevice::sum_read(const AmsAddress& server, const ReadWriteRequest& request,
                                    LittleWriter& data) {
  const std::size_t n = request.index_offset;
  if (n > kSumItemsMax || request.data.size() != n * kSumItemSize) return ads_error::invalid_size;
  std::size_t total = n * sizeof(std::uint32_t);
  for (std::size_t i = 0; i < n; ++i) total += sum_item(request.data, i).length;
  if (total > request.read_length || total > data_.size()) return ads_error::invalid_size;
  const auto error_of = [&](const SumItem& item, const Place& found) {
    return found.error == ads_error::none && item.length > found.bytes.size() ? ads_error::invalid_size
                                                                              : found.error;
  };
  for (std::size_t i = 0; i < n; ++i) {
    const SumItem item = sum_item(request.data, i);
    data.write(error_of(item, place(server, item.index_group, item.index_offset)));
  }
  for (std::size_t i = 0; i < n; ++i) {
    const SumItem item = sum_item(request.data, i);
    const Place found = place(server, item.index_group, item.index_offset);
    if (error_of(item, found) == ads_error::none) {
      data.write_bytes(found.bytes.first(item.length));
    } else {
      for (std::uint32_t k = 0; k < item.length; ++k) data.write(std::uint8_t{0});
    }
  }
  return ads_error::none;
}

std::uint32_t WinchDevice::sum_write(const AmsAddress& server, const ReadWriteRequest& request,
                                     LittleWriter& data) {
  const std::size_t n = request.index_offset;
  if (n > kSumItemsMax || request.data.size() < n * kSumItemSize) return ads_error::invalid_size;
  LittleReader values{request.data.subspan(n * kSumItemSize)};
  std::size_t total = 0;
  for (std::size_t i = 0; i < n; ++i) total += sum_item(request.data, i).length;
  if (total != values.remaining()) return ads_error::invalid_size;
  for (std::size_t i = 0; i < n; ++i) {
    const SumItem item = sum_item(request.data, i);
    data.write(write_value(server, item.index_group, item.index_offset, values.take(item.length)));
  }
  return ads_error::none;
}

WinchDevice::Place WinchDevice::place(const AmsAddress& server, std::uint32_t group, std::uint32_t offset) {
  LittleWriter made{scratch_};
  if (server.port == ams_port::system_service) {
    if (group != index_group::system_state_ex) return {ads_error::invalid_index_group};
    constexpr std::uint8_t kRealTimePlatform = 3;
    made.write(static_cast<std::uint16_t>(state_ == AdsState::stop ? AdsState::run : state_));
    made.write(std::uint16_t{0});
    made.write(std::uint16_t{1});
    made.write(kSystemInfo.major);
    made.write(kSystemInfo.minor);
    made.write(kSystemInfo.build);
    made.write(kRealTimePlatform);
    made.write(std::uint8_t{1});
    made.write(std::uint16_t{0});
    made.write(std::uint16_t{0});
    return {ads_error::none, made.written()};
  }
  const MutableBytes memory = plc_.memory();
  switch (group) {
    case index_group::value_by_handle: {
      const auto handle =
          std::find_if(handles_.begin(), handles_.end(), [&](const Handle& h) { return h.id == offset; });
      if (handle == handles_.end()) return {ads_error::invalid_index_offset};
      const Symbol& named = symbols_[handle->symbol];
      const auto bytes = memory.subspan(named.offset, named.size);
      return {ads_error::none, bytes, bytes};
    }
    case index_group::plc_data: {
      if (offset >= memory.size()) return {ads_error::invalid_index_offset};
      const auto bytes = memory.subspan(offset);
      return {ads_error::none, bytes, bytes};
    }
    case index_group::symbol_version:
      made.write(symbol_version_);
      return {ads_error::none, made.written()};
    case index_group::device_data:
      if (offset != 0) return {ads_error::invalid_index_offset};
      made.write(static_cast<std::uint16_t>(state_));
      made.write(std::uint16_t{0});
      return {ads_error::none, made.written()};
    default:
      return {ads_error::invalid_index_group};
  }
}

std::uint32_t WinchDevice::write_value(const AmsAddress& server, std::uint32_t group, std::uint32_t offset,
                                       Bytes data) {
  if (group == index_group::release_handle && server.port == config_.plc_port) {
    if (data.size() != sizeof(std::uint32_t)) return ads_error::invalid_size;
    const auto id = load<std::uint32_t, std::endian::little>(data);
    const bool released = std::erase_if(handles_, [&](const Handle& h) { return h.id == id; }) > 0;
    return released ? ads_error::none : ads_error::invalid_index_offset;
  }
  const Place found = place(server, group, offset);
  if (found.error != ads_error::none) return found.error;
  if (found.writable.empty()) return ads_error::access_denied;
  const bool fits = group == index_group::value_by_handle ? data.size() == found.writable.size()
                                                          : data.size() <= found.writable.size();
  if (!fits) return ads_error::invalid_size;
  std::copy(data.begin(), data.end(), found.writable.begin());
  return ads_error::none;
}

void WinchDevice::serve_control(Session& session, const AmsFrame& frame) {
  const auto request = WriteControlRequest::decode(frame.data);
  std::uint32_t result = ads_error::none;
  if (!request) {
    ++malformed_;
    result = ads_error::invalid_size;
  } else if (request->ads_state == AdsState::run || request->ads_state == AdsState::reset) {
    set_state(AdsState::run);
  } else if (request->ads_state == AdsState::stop) {
    set_state(AdsState::stop);
  } else if (request->ads_state == AdsState::reconfig) {
    set_state(AdsState::config);
  } else {
    result = ads_error::service_not_supported;
  }
  answer(session, frame.header, ResultResponse{result});
}

void WinchDevice::set_state(AdsState state) {
  state_ = state;
  plc_.run(state == AdsState::run);
}

// Notifications

void WinchDevice::serve_subscribe(Session& session, const AmsFrame& frame) {
  const auto request = AddNotificationRequest::decode(frame.data);
  if (!request) {
    ++malformed_;
    answer(session, frame.header, AddNotificationResponse{ads_error::invalid_size, 0});
    return;
  }
  const AmsAddress& server = frame.header.target;
  const Place found = place(server, request->index_group, request->index_offset);
  const auto mode = static_cast<NotificationMode>(request->mode);
  std::uint32_t error = found.error;
  if (error == ads_error::none && mode != NotificationMode::cyclic && mode != NotificationMode::on_change) {
    error = ads_error::invalid_data;
  } else if (error == ads_error::none && (request->length == 0 || request->length > found.bytes.size())) {
    error = ads_error::invalid_size;
  } else if (error == ads_error::none && subscriptions_.size() >= kSubscriptionsMax) {
    error = ads_error::no_more_handles;
  }
  if (error != ads_error::none) {
    answer(session, frame.header, AddNotificationResponse{error, 0});
    return;
  }
  const auto task_period = from_seconds(config_.plc.task_period_s);
  Subscription subscription;
  subscription.handle = next_subscription_++;
  subscription.server = server;
  subscription.client = frame.header.source;
  subscription.item = {request->index_group, request->index_offset, request->length};
  subscription.mode = mode;
  subscription.period = std::max(request->cycle_time, task_period);
  subscription.due = now_ + subscription.period;
  subscriptions_.push_back(std::move(subscription));
  const SessionId id = session.id;
  answer(session, frame.header, AddNotificationResponse{ads_error::none, subscriptions_.back().handle});
  if (find(id) == nullptr) return;
  send_sample(subscriptions_.back(),
              place(server, request->index_group, request->index_offset).bytes.first(request->length));
}

void WinchDevice::serve_unsubscribe(Session& session, const AmsFrame& frame) {
  const auto request = DeleteNotificationRequest::decode(frame.data);
  std::uint32_t result = ads_error::invalid_size;
  if (request) {
    const bool removed = std::erase_if(subscriptions_, [&](const Subscription& s) {
                           return s.handle == request->handle && s.client == frame.header.source;
                         }) > 0;
    result = removed ? ads_error::none : ads_error::notification_handle_invalid;
  } else {
    ++malformed_;
  }
  answer(session, frame.header, ResultResponse{result});
}

void WinchDevice::notify(LabTime t) {
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
    subscription.due += subscription.period;
    if (subscription.due <= t) subscription.due = t + subscription.period;
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
  const Nanoseconds t_plc = now_.time_since_epoch() + config_.plc.clock_ahead + clock_jump_;
  const NotificationStamp stamp{to_filetime(t_plc), {&sample, 1}};
  const AmsHeader header{subscription.client,
                         subscription.server,
                         static_cast<std::uint16_t>(AdsCommand::notification),
                         kRequestFlags,
                         0,
                         0};
  if (const auto frame = encode_frame(frame_, header, NotificationStream{{&stamp, 1}}))
    transmit(*session, *frame);
}

// Time

void WinchDevice::cycle(LabTime t, const Measurement& measurement) {
  now_ = t;
  plc_.cycle(t, measurement);
  notify(t);
}

void WinchDevice::step(LabTime now) {
  now_ = now;
  for (auto& session : sessions_) {
    while (!session.held.empty() && session.held.front().due <= now) {
      (void)out_.send(session.id, session.held.front().bytes);  // a peer that is gone is told by on_closed
      session.held.pop_front();
    }
  }
}

// Sending

template <class Message>
void WinchDevice::answer(Session& session, const AmsHeader& request, const Message& message,
                         std::uint32_t ams_error) {
  if (const auto frame = encode_frame(frame_, request.reply(ams_error), message)) transmit(session, *frame);
}

void WinchDevice::transmit(Session& session, Bytes frame) {
  if (faults_.silent) return;
  ++frames_sent_;
  if (faults_.close_mid_frame) {
    faults_.close_mid_frame = false;
    (void)out_.send(session.id, frame.first(frame.size() / 2));
    drop(session.id);
    return;
  }
  Nanoseconds delay = faults_.late.value_or(Nanoseconds{0});
  if (faults_.outlier_every && frames_sent_ % *faults_.outlier_every == 0) delay += 100ms;
  if (faults_.half_frames) {
    send_or_hold(session, frame.first(frame.size() / 2), delay);
    send_or_hold(session, frame.subspan(frame.size() / 2), delay + 1ms);
  } else {
    send_or_hold(session, frame, delay);
  }
}

void WinchDevice::send_or_hold(Session& session, Bytes bytes, Nanoseconds delay) {
  if (session.held.empty() && delay == Nanoseconds{0}) {
    (void)out_.send(session.id, bytes);  // a peer that is gone is told by on_closed
    return;
  }
  LabTime due = now_ + delay;
  if (!session.held.empty()) due = std::max(due, session.held.back().due);
  session.held.push_back({due, ByteBuffer{bytes.begin(), bytes.end()}});
}

// Faults

Status WinchDevice::set_fault(std::string_view name, bool active, double value) {
  if (name == "silent") {
    faults_.silent = active;
  } else if (name == "late") {
    faults_.late.reset();
    if (active) faults_.late = from_seconds(value > 0 ? value : 0.2);
  } else if (name == "drop_route") {
    faults_.drop_route = active;
    while (active && !sessions_.empty()) drop(sessions_.back().id);
  } else if (name == "stop_plc") {
    const bool config = value == static_cast<double>(AdsState::config);
    set_state(!active ? AdsState::run : config ? AdsState::config : AdsState::stop);
  } else if (name == "frozen_cycle") {
    plc_.freeze_cycle_count(active);
  } else if (name == "drive_fault") {
    constexpr std::uint32_t kSomeFault = 0xF000;
    const bool named = value >= 1 && value <= 4294967295.0;
    plc_.drive_fault(active ? std::optional{named ? static_cast<std::uint32_t>(value) : kSomeFault}
                            : std::nullopt);
  } else if (name == "close_mid_frame") {
    faults_.close_mid_frame = active;
  } else if (name == "half_frames") {
    faults_.half_frames = active;
  } else if (name == "outlier_100ms") {
    faults_.outlier_every.reset();
    if (active) faults_.outlier_every = value >= 1 ? static_cast<std::uint64_t>(value) : 50;
  } else {
    return kUnknownFault;
  }
  return Done{};
}

}  // namespace motionlab::winch
