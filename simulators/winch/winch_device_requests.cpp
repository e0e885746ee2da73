#include <algorithm>

#include "simulators/winch/winch_device.hpp"

namespace motionlab::winch {

namespace {

constexpr DeviceInfoResponse kPlcInfo{0, 3, 1, 4022, "Plc30 App"};
constexpr DeviceInfoResponse kSystemInfo{0, 3, 1, 4022, "TwinCAT System"};

}  // namespace

template <class Message>
void WinchDevice::answer(Session& session, const AmsHeader& request, const Message& message,
                         std::uint32_t ams_error) {
  if (const auto frame = encode_frame(frame_, request.reply(ams_error), message)) transmit(session, *frame);
}

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
  if (faults_.ads_error != ads_error::none && header.target.port == config_.plc_port) {
    answer(session, header, ResultResponse{faults_.ads_error});
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
  LittleWriter data{data_};
  std::uint32_t result = read_write(frame.header, *request, data);
  if (result == ads_error::none && (!data.ok() || data.position() > request->read_length)) {
    result = ads_error::invalid_size;
  }
  const SessionId id = session.id;
  answer(session, frame.header, ReadResponse{result, result == ads_error::none ? data.written() : Bytes{}});
  if (find(id) != nullptr) send_first_samples();
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

void WinchDevice::serve_subscribe(Session& session, const AmsFrame& frame) {
  const auto request = AddNotificationRequest::decode(frame.data);
  if (!request) {
    ++malformed_;
    answer(session, frame.header, AddNotificationResponse{ads_error::invalid_size, 0});
    return;
  }
  const SessionId id = session.id;
  answer(session, frame.header, subscribe(frame.header, *request));
  if (find(id) != nullptr) send_first_samples();
}

void WinchDevice::serve_unsubscribe(Session& session, const AmsFrame& frame) {
  const auto request = DeleteNotificationRequest::decode(frame.data);
  std::uint32_t result = ads_error::invalid_size;
  if (request) {
    result = unsubscribe(frame.header.source, request->handle);
  } else {
    ++malformed_;
  }
  answer(session, frame.header, ResultResponse{result});
}

}  // namespace motionlab::winch
