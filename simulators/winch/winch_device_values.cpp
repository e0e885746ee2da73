#include <algorithm>

#include "simulators/winch/winch_device.hpp"

namespace motionlab::winch {

namespace {
constexpr std::size_t kHandlesMax = 4096;
}  // namespace

/// From an offset of the data area to the end of the variables that lie there; empty where none do.
MutableBytes WinchDevice::data_area(std::uint32_t offset) {
  if (offset < data_at_) return {};
  const std::uint32_t at = offset - data_at_;
  if (at >= kMainAt) {
    const MutableBytes main = legacy_.memory();
    return at - kMainAt < main.size() ? main.subspan(at - kMainAt) : MutableBytes{};
  }
  const MutableBytes gvl = plc_.memory();
  return at < gvl.size() ? gvl.subspan(at) : MutableBytes{};
}

WinchDevice::Place WinchDevice::place_by_handle(std::uint32_t id) {
  const auto handle =
      std::find_if(handles_.begin(), handles_.end(), [&](const Handle& h) { return h.id == id; });
  if (handle == handles_.end()) return {ads_error::invalid_index_offset};
  if (!handle->valid) return {ads_error::symbol_version_invalid};
  const SymbolTable::Symbol& named = symbols_.at(handle->symbol);
  const auto bytes = data_area(data_at_ + named.offset).first(named.size);
  return {ads_error::none, bytes, bytes};
}

/// What the system service tells clients that ask more than the state.
Bytes WinchDevice::system_state() {
  constexpr std::uint8_t kRealTimePlatform = 3;
  LittleWriter made{scratch_};
  made.write(static_cast<std::uint16_t>(state_ == AdsState::stop ? AdsState::run : state_));
  made.write(std::uint16_t{0});     // device state
  made.write(std::uint16_t{1});     // restart index
  made.write(std::uint8_t{3});      // version
  made.write(std::uint8_t{1});      // revision
  made.write(std::uint16_t{4022});  // build
  made.write(kRealTimePlatform);
  made.write(std::uint8_t{1});   // operating system
  made.write(std::uint16_t{0});  // flags
  made.write(std::uint16_t{0});
  return made.written();
}

WinchDevice::Place WinchDevice::place(const AmsAddress& server, std::uint32_t group, std::uint32_t offset) {
  if (server.port == ams_port::system_service) {
    if (group != index_group::system_state_ex) return {ads_error::invalid_index_group};
    return {ads_error::none, system_state()};
  }
  LittleWriter made{scratch_};
  LittleWriter all{item_};
  switch (group) {
    case index_group::value_by_handle:
      return place_by_handle(offset);
    case index_group::plc_memory:  // the projects have no variables there
      return {ads_error::invalid_index_offset};
    case index_group::plc_data: {
      const auto bytes = data_area(offset);
      if (bytes.empty()) return {ads_error::invalid_index_offset};
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
    case index_group::upload_info:
      symbols_.upload_info().encode_short(made);
      return {ads_error::none, made.written()};
    case index_group::upload_info_2:
      symbols_.upload_info().encode(made);
      return {ads_error::none, made.written()};
    case index_group::upload:
      symbols_.write_entries(data_at_, all);
      return {ads_error::none, all.written()};
    case index_group::upload_types:
      symbols_.write_types(all);
      return {ads_error::none, all.written()};
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

std::uint32_t WinchDevice::read_write(const AmsHeader& header, const ReadWriteRequest& request,
                                      LittleWriter& answer) {
  if (header.target.port == ams_port::system_service) return ads_error::invalid_index_group;
  return is_sum(request.index_group) ? sum(header, request, answer) : read_by_name(request, answer);
}

std::uint32_t WinchDevice::read_by_name(const ReadWriteRequest& request, LittleWriter& answer) {
  const std::string_view name = symbol_name(request.data);
  if (request.index_group == index_group::type_by_name) {
    return symbols_.write_type(name, answer) ? ads_error::none : ads_error::symbol_not_found;
  }
  const auto group = request.index_group;
  if (group != index_group::handle_by_name && group != index_group::value_by_name &&
      group != index_group::info_by_name && group != index_group::info_by_name_ex) {
    return ads_error::invalid_index_group;
  }
  const SymbolTable::Symbol* found = symbols_.find(name);
  if (found == nullptr) return ads_error::symbol_not_found;
  switch (group) {
    case index_group::info_by_name:
      SymbolPlace{index_group::plc_data, data_at_ + found->offset, found->size}.encode(answer);
      return ads_error::none;
    case index_group::info_by_name_ex:
      symbols_.write_entry(*found, data_at_, answer);
      return ads_error::none;
    case index_group::value_by_name:
      answer.write_bytes(data_area(data_at_ + found->offset).first(found->size));
      return ads_error::none;
    default:
      return give_handle(*found, request.read_length, answer);
  }
}

std::uint32_t WinchDevice::give_handle(const SymbolTable::Symbol& symbol, std::uint32_t read_length,
                                       LittleWriter& answer) {
  if (handles_.size() >= kHandlesMax) return ads_error::no_more_handles;
  if (read_length < sizeof(std::uint32_t)) return ads_error::invalid_size;
  const Handle handle{next_handle_++, symbols_.index_of(symbol)};
  handles_.push_back(handle);
  if (read_length == sizeof(std::uint32_t)) {
    answer.write(handle.id);
  } else {
    LongHandle{handle.id, symbol.size, 0, symbol.type}.encode(answer);
  }
  return ads_error::none;
}

}  // namespace motionlab::winch
