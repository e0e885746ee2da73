// The simulated controller as an ADS server: what an ordinary client asks, and what only a broken one does.
#include "simulators/winch/winch_device.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <sstream>
#include <string>
#include <vector>

namespace motionlab::winch {
namespace {

using V = std::vector<std::uint8_t>;

/// A client that speaks raw frames and keeps whole answers.
class Client : public ServerOut {
 public:
  explicit Client(DeviceConfig config = {}) : dut(std::move(config), *this) {
    dut.on_accepted(1, {0x0A000001, 5000}, t);
    dut.cycle(t, {2.0, 0.0, 0.0, 40.0});
  }

  Status send(SessionId, Bytes bytes) override {
    splitter_.append(bytes);
    while (true) {
      const auto next = splitter_.next();
      EXPECT_TRUE(next.ok());
      if (!next.ok() || !*next) return Done{};
      const TcpFrame frame = **next;
      bodies.emplace_back(frame.body.begin(), frame.body.end());
    }
  }
  void close(SessionId id) override { closed.push_back(id); }

  /// The AMS answer to one request; its data are in `data`.
  template <class Message>
  AmsHeader ask(AdsCommand command, const Message& message,
                AmsAddress target = {DeviceConfig{}.net_id, 851}) {
    std::array<std::uint8_t, 1024> buffer{};
    const auto frame = encode_frame(
        buffer, AmsHeader{target, self, static_cast<std::uint16_t>(command), kRequestFlags, 0, ++invoke},
        message);
    bodies.clear();
    data.clear();
    dut.on_bytes(1, *frame, t);
    if (bodies.empty()) return {};
    const auto answer = decode_ams(bodies.front());
    data.assign(answer->data.begin(), answer->data.end());
    EXPECT_EQ(answer->header.invoke_id, invoke);
    EXPECT_EQ(answer->header.target, self);
    EXPECT_EQ(answer->header.source, target);
    EXPECT_EQ(answer->header.flags, kResponseFlags);
    return answer->header;
  }

  V read_write(std::uint32_t group, std::uint32_t offset, std::uint32_t length, Bytes bytes) {
    ask(AdsCommand::read_write, ReadWriteRequest{group, offset, length, bytes});
    return answered();
  }
  V read(std::uint32_t group, std::uint32_t offset, std::uint32_t length) {
    ask(AdsCommand::read, ReadRequest{group, offset, length});
    return answered();
  }
  std::uint32_t write(std::uint32_t group, std::uint32_t offset, Bytes bytes) {
    ask(AdsCommand::write, WriteRequest{group, offset, bytes});
    return ResultResponse::decode(data)->result;
  }
  std::uint32_t handle(std::string_view name) {
    const V bytes = read_write(0xF003, 0, 4, as_bytes(name));
    return bytes.size() == 4 ? load<std::uint32_t, std::endian::little>(bytes) : 0;
  }

  WinchDevice dut;
  AmsAddress self{{{10, 0, 0, 1, 1, 1}}, 32750};
  LabTime t{1s};
  std::uint32_t invoke = 0;
  std::uint32_t result = 0;
  std::vector<V> bodies;
  std::vector<SessionId> closed;
  V data;

 private:
  V answered() {
    const auto response = ReadResponse::decode(data);
    EXPECT_TRUE(response.ok());
    if (!response) return {};
    result = response->result;
    return {response->data.begin(), response->data.end()};
  }

  FrameSplitter splitter_;
};

TEST(WinchDevice, AnswersStateAndInfoOnBothPorts) {
  Client client;
  const AmsAddress system{DeviceConfig{}.net_id, 10000};
  client.ask(AdsCommand::read_state, NoData{});
  EXPECT_EQ(client.data, (V{0, 0, 0, 0, 5, 0, 0, 0}));
  client.ask(AdsCommand::read_state, NoData{}, system);
  EXPECT_EQ(client.data, (V{0, 0, 0, 0, 5, 0, 0, 0}));
  client.ask(AdsCommand::read_device_info, NoData{});
  EXPECT_EQ(client.data.size(), 24U);
  client.ask(AdsCommand::read, ReadRequest{0x00F0, 0, 0xFFFFFFFF}, system);
  EXPECT_EQ(client.data.size(), 8U + 16U);
  ASSERT_TRUE(client.dut.set_fault("stop_plc", true).ok());
  client.ask(AdsCommand::read_state, NoData{});
  EXPECT_EQ(client.data[4], 6);
  client.ask(AdsCommand::read_state, NoData{}, system);
  EXPECT_EQ(client.data[4], 5) << "the system runs while its PLC is stopped";
  ASSERT_TRUE(client.dut.set_fault("stop_plc", true, 15).ok());
  EXPECT_EQ(client.ask(AdsCommand::read_state, NoData{}).error, 6U);
}

TEST(WinchDevice, GivesHandlesInShortAndLongFormWithAndWithoutNul) {
  Client client;
  const auto a = client.handle("GVL_Winch.stStatus");
  const auto b = client.handle({"gvl_winch.STSTATUS\0", 19});
  EXPECT_NE(a, 0U);
  EXPECT_NE(b, 0U);
  EXPECT_NE(a, b);
  const V answer = client.read_write(0xF003, 0, 0xFFFFFFFF, as_bytes("GVL_Winch.stStatus"));
  ASSERT_EQ(answer.size(), 4U + 4U + 4U + 2U + 15U);
  EXPECT_EQ(answer[4], 120);
  EXPECT_EQ(answer[12], 14);
  EXPECT_EQ(as_text(Bytes{answer}.subspan(14, 14)), "ST_WinchStatus");
  EXPECT_EQ(client.handle("GVL_Winch.nothing"), 0U);
  EXPECT_EQ(client.result, 0x710U);
}

TEST(WinchDevice, ReadsAndWritesByHandleAndByOffset) {
  Client client;
  const auto command = client.handle("GVL_Winch.stCommand");
  const V value(64, 0x11);
  EXPECT_EQ(client.write(0xF005, command, value), 0U);
  EXPECT_EQ(client.read(0xF005, command, 64), value);
  EXPECT_EQ(client.read(0xF005, command, 0xFFFFFFFF), value) << "never more than there is";
  EXPECT_EQ(client.read(0xF005, command, 3), V(3, 0x11)) << "never more than asked for";
  EXPECT_EQ(client.write(0xF005, command, Bytes{value}.first(63)), 0x705U);
  EXPECT_EQ(client.write(0xF005, 9999, value), 0x703U);
  const auto speed = client.handle("GVL_Winch.stCommand.fSetVelocity");
  EXPECT_EQ(client.write(0xF005, speed, Bytes{value}.first(8)), 0U);
  EXPECT_EQ(client.read(0x4040, 64 + 4, 4), (V{1, 0, 0, 0})) << "nCycleCount after one cycle";
  EXPECT_EQ(client.write(0x4040, 60, V(8, 1)), 0U);
  EXPECT_EQ(client.write(0x4040, 180, V(5, 1)), 0x705U);
  EXPECT_TRUE(client.read(0x4040, 184, 1).empty());
  EXPECT_EQ(client.result, 0x703U);
  EXPECT_TRUE(client.read(0x1234, 0, 1).empty());
  EXPECT_EQ(client.result, 0x702U);
  EXPECT_EQ(client.write(0xF008, 0, V(1, 1)), 0x704U);
  std::array<std::uint8_t, 4> released{};
  store<std::endian::little>(released, command);
  EXPECT_EQ(client.write(0xF006, 0, released), 0U);
  EXPECT_EQ(client.write(0xF006, 0, released), 0x703U);
  EXPECT_TRUE(client.read(0xF005, command, 64).empty());
}

TEST(WinchDevice, DescribesItsSymbols) {
  Client client;
  EXPECT_EQ(client.read_write(0xF007, 0, 12, as_bytes("GVL_Winch.stStatus")),
            (V{0x40, 0x40, 0, 0, 64, 0, 0, 0, 120, 0, 0, 0}));
  const V entry = client.read_write(0xF009, 0, 0xFFFFFFFF, as_bytes("GVL_Winch.stStatus.fActPosition"));
  const auto decoded = SymbolEntry::decode(entry);
  ASSERT_TRUE(decoded.ok());
  EXPECT_EQ(decoded->place, (SymbolPlace{0x4040, 64 + 24, 8}));
  EXPECT_EQ(decoded->type, "LREAL");
  EXPECT_EQ(decoded->data_type, DataType::lreal);
  (void)client.read_write(0xF009, 0, 8, as_bytes("GVL_Winch.stStatus"));
  EXPECT_EQ(client.result, 0x705U) << "an entry longer than asked for";
}

TEST(WinchDevice, ServesSumReadsAndSumWrites) {
  Client client;
  const auto heartbeat = client.handle("GVL_Winch.stCommand.nHeartbeat");
  std::array<std::uint8_t, 128> buffer{};
  LittleWriter writes{buffer};
  SumItem{0xF005, heartbeat, 4}.encode(writes);
  SumItem{0xF005, 77, 2}.encode(writes);
  writes.write_bytes(V{7, 0, 0, 0, 1, 1});
  EXPECT_EQ(client.read_write(0xF081, 2, 8, writes.written()), (V{0, 0, 0, 0, 0x03, 0x07, 0, 0}));
  LittleWriter reads{buffer};
  SumItem{0xF005, 77, 2}.encode(reads);
  SumItem{0xF005, heartbeat, 4}.encode(reads);
  EXPECT_EQ(client.read_write(0xF080, 2, 14, reads.written()),
            (V{0x03, 0x07, 0, 0, 0, 0, 0, 0, 0, 0, 7, 0, 0, 0}));
  (void)client.read_write(0xF080, 2, 13, reads.written());
  EXPECT_EQ(client.result, 0x705U);
  (void)client.read_write(0xF080, 3, 100, reads.written());
  EXPECT_EQ(client.result, 0x705U);
  (void)client.read_write(0xF080, 0xFFFFFFFF, 100, reads.written());
  EXPECT_EQ(client.result, 0x705U);
}

TEST(WinchDevice, SendsTheFirstSampleAtOnceThenOnScheduleOrOnChange) {
  Client client;
  const auto status = client.handle("GVL_Winch.stStatus");
  client.ask(AdsCommand::add_notification, AddNotificationRequest{0xF005, status, 120, 3, 0ms, 10ms});
  const auto cyclic = AddNotificationResponse::decode(client.data);
  ASSERT_TRUE(cyclic.ok());
  EXPECT_NE(cyclic->handle, 0U);
  ASSERT_EQ(client.bodies.size(), 2U) << "the answer, then the first sample";
  const auto first = decode_ams(client.bodies[1]);
  EXPECT_EQ(first->header.flags, 0x0004);
  EXPECT_EQ(first->header.command, 8);
  EXPECT_EQ(first->header.target, client.self);
  EXPECT_EQ(first->header.invoke_id, 0U);
  EXPECT_EQ(client.bodies[1].size() + kTcpHeaderSize, 186U);

  client.ask(AdsCommand::add_notification, AddNotificationRequest{0xF100, 0, 4, 4, 0ms, 0ms});
  EXPECT_EQ(client.bodies.size(), 2U);
  client.bodies.clear();
  for (int i = 0; i < 20; ++i) client.dut.cycle(client.t += 5ms, {2.0, 0.0, 0.0, 40.0});
  EXPECT_EQ(client.bodies.size(), 10U) << "100 ms at 10 ms; the state did not change";
  ASSERT_TRUE(client.dut.set_fault("stop_plc", true).ok());
  client.bodies.clear();
  for (int i = 0; i < 20; ++i) client.dut.cycle(client.t += 5ms, {2.0, 0.0, 0.0, 40.0});
  EXPECT_EQ(client.bodies.size(), 1U) << "the state changed; the task sends nothing";
  client.ask(AdsCommand::delete_notification, DeleteNotificationRequest{cyclic->handle});
  EXPECT_EQ(ResultResponse::decode(client.data)->result, 0U);
  client.ask(AdsCommand::delete_notification, DeleteNotificationRequest{cyclic->handle});
  EXPECT_EQ(ResultResponse::decode(client.data)->result, 0x714U);
}

TEST(WinchDevice, RefusesSubscriptionsItCannotServe) {
  Client client;
  const auto status = client.handle("GVL_Winch.stStatus");
  const auto subscribe = [&](std::uint32_t offset, std::uint32_t length, std::uint32_t mode) {
    client.ask(AdsCommand::add_notification, AddNotificationRequest{0xF005, offset, length, mode, 0ms, 0ms});
    return AddNotificationResponse::decode(client.data)->result;
  };
  EXPECT_EQ(subscribe(status, 121, 3), 0x705U);
  EXPECT_EQ(subscribe(status, 0, 3), 0x705U);
  EXPECT_EQ(subscribe(status, 120, 10), 0x706U);
  EXPECT_EQ(subscribe(status + 1, 120, 3), 0x703U);
  for (int i = 0; i < 550; ++i) ASSERT_EQ(subscribe(status, 4, 3), 0U);
  EXPECT_EQ(subscribe(status, 4, 3), 0x716U);
}

TEST(WinchDevice, AnswersRoutingErrorsAndUnknownCommands) {
  Client client;
  const NetId net_id = DeviceConfig{}.net_id;
  EXPECT_EQ(client.ask(AdsCommand::read_state, NoData{}, {net_id, 500}).error, 6U);
  EXPECT_EQ(client.ask(AdsCommand::read_state, NoData{}, {{{1, 1, 1, 1, 1, 1}}, 851}).error, 7U);
  EXPECT_EQ(client.ask(static_cast<AdsCommand>(77), NoData{}).error, 0U);
  EXPECT_EQ(ResultResponse::decode(client.data)->result, 0x701U);
  client.ask(AdsCommand::read, NoData{});
  EXPECT_EQ(ReadResponse::decode(client.data)->result, 0x705U);
  EXPECT_EQ(client.dut.malformed(), 1U);
}

TEST(WinchDevice, RegistersAPortAndLetsItGo) {
  Client client;
  const V connect = {0x00, 0x10, 2, 0, 0, 0, 0, 0};
  client.dut.on_bytes(1, connect, client.t);
  ASSERT_EQ(client.bodies.size(), 1U);
  EXPECT_EQ(client.bodies[0], (V{192, 168, 90, 150, 1, 1, 0x00, 0x80}));
  const V close = {0x01, 0x00, 2, 0, 0, 0, 0x00, 0x80};
  client.dut.on_bytes(1, close, client.t);
  EXPECT_EQ(client.bodies.size(), 1U);
  EXPECT_EQ(client.closed, (std::vector<SessionId>{1})) << "as a router answers";
}

TEST(WinchDevice, ClosesOnAMalformedStreamAndOnAnUnknownSource) {
  Client client;
  client.dut.on_bytes(1, as_bytes("GET / HTTP/1.1\r\n"), client.t);
  EXPECT_EQ(client.closed, (std::vector<SessionId>{1}));
  EXPECT_EQ(client.dut.sessions(), 0U);
  DeviceConfig config;
  config.routes = {NetId{{9, 9, 9, 9, 1, 1}}};
  Client stranger{config};
  stranger.ask(AdsCommand::read_state, NoData{});
  EXPECT_TRUE(stranger.bodies.empty());
  EXPECT_EQ(stranger.closed.size(), 1U);
}

TEST(WinchDevice, StopsAndStartsThePlcOnWriteControl) {
  Client client;
  client.ask(AdsCommand::write_control, WriteControlRequest{AdsState::stop, 0, {}});
  client.ask(AdsCommand::read_state, NoData{});
  EXPECT_EQ(client.data[4], 6);
  client.ask(AdsCommand::write_control, WriteControlRequest{AdsState::run, 0, {}});
  client.ask(AdsCommand::read_state, NoData{});
  EXPECT_EQ(client.data[4], 5);
  client.ask(AdsCommand::write_control, WriteControlRequest{AdsState::suspend, 0, {}});
  EXPECT_EQ(ResultResponse::decode(client.data)->result, 0x701U);
}

TEST(WinchDevice, RefusesAnUnknownFaultAndNamesTheKnown) {
  Client client;
  const auto status = client.dut.set_fault("explode", true);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.fault().reason, Reason::refused);
  std::istringstream names{std::string{WinchDevice::fault_names()}};
  int n = 0;
  for (std::string name; names >> name; ++n) {
    EXPECT_NE(status.fault().text.find(name), std::string_view::npos) << name;
    EXPECT_TRUE(client.dut.set_fault(name, true).ok()) << name;
    EXPECT_TRUE(client.dut.set_fault(name, false).ok()) << name;
  }
  EXPECT_EQ(n, 19);
}

TEST(WinchDevice, IsOkAgainAfterEveryFault) {
  std::istringstream names{std::string{WinchDevice::fault_names()}};
  for (std::string name; names >> name;) {
    if (name == "close_mid_frame") continue;  // it waits for a frame, and is over with it
    Client client;
    ASSERT_TRUE(client.dut.set_fault(name, true).ok());
    client.dut.cycle(client.t += 5ms, {2.0, 0.0, 0.0, 40.0});
    ASSERT_TRUE(client.dut.set_fault(name, false).ok());
    client.dut.on_accepted(1, {0x0A000001, 5000}, client.t);
    client.dut.cycle(client.t += 5ms, {2.0, 0.0, 0.0, 40.0});
    client.ask(AdsCommand::read_state, NoData{});
    EXPECT_EQ(client.data, (V{0, 0, 0, 0, 5, 0, 0, 0})) << name;
    const auto status = PlcStatus::decode(client.read_write(0xF004, 0, 120, as_bytes("GVL_Winch.stStatus")));
    ASSERT_TRUE(status.ok()) << name << ": " << status.fault().text;
    EXPECT_EQ(status->position_m, 0.8) << name;
  }
}

TEST(WinchDevice, MovesItsVariablesAndVoidsHandlesOnAnOnlineChange) {
  Client client;
  const auto status = client.handle("GVL_Winch.stStatus");
  client.ask(AdsCommand::add_notification, AddNotificationRequest{0xF008, 0, 1, 4, 0ms, 0ms});
  client.ask(AdsCommand::add_notification, AddNotificationRequest{0xF005, status, 120, 3, 0ms, 10ms});
  const V before = client.read_write(0xF007, 0, 12, as_bytes("GVL_Winch.stStatus"));
  const V version = client.read(0xF008, 0, 1);
  client.bodies.clear();
  ASSERT_TRUE(client.dut.set_fault("online_change", true).ok());
  ASSERT_EQ(client.bodies.size(), 1U) << "the one-time hint";
  const auto hint = decode_ams(client.bodies[0]);
  ASSERT_TRUE(hint.ok());
  NotificationReader samples = *NotificationReader::open(hint->data);
  EXPECT_TRUE(samples.next()->sample.data.empty());
  EXPECT_EQ(client.dut.subscriptions(), 1U) << "that of the symbol version lives on";
  EXPECT_EQ(client.read(0xF008, 0, 1)[0], version[0] + 1);
  (void)client.read(0xF005, status, 120);
  EXPECT_EQ(client.result, 0x711U);
  EXPECT_NE(client.read_write(0xF007, 0, 12, as_bytes("GVL_Winch.stStatus")), before);
  EXPECT_EQ(client.read(0xF005, client.handle("GVL_Winch.stStatus"), 120).size(), 120U);
}

TEST(WinchDevice, TellsAllItsSymbolsAndTypesAtOnce) {
  Client client;
  const auto info = UploadInfo::decode(client.read(0xF00F, 0, 0xFFFFFFFF));
  ASSERT_TRUE(info.ok());
  const auto short_info = UploadInfo::decode(client.read(0xF00C, 0, 8));
  ASSERT_TRUE(short_info.ok());
  EXPECT_EQ(short_info->symbol_bytes, info->symbol_bytes);
  const V all = client.read(0xF00B, 0, info->symbol_bytes);
  ASSERT_EQ(all.size(), info->symbol_bytes);
  EntryReader entries{all};
  std::uint32_t n = 0;
  bool found = false;
  while (true) {
    const auto next = entries.next();
    ASSERT_TRUE(next.ok());
    if (!*next) break;
    const auto entry = SymbolEntry::decode(**next);
    ASSERT_TRUE(entry.ok());
    found = found || entry->name == "MAIN.winch.length_t";
    ++n;
  }
  EXPECT_EQ(n, info->symbols);
  EXPECT_TRUE(found);
  const V types = client.read(0xF00E, 0, 0xFFFFFFFF);
  EXPECT_EQ(types.size(), info->type_bytes);
  EntryReader walk{types};
  std::uint32_t members = 0;
  for (std::uint32_t i = 0; i < info->types; ++i) {
    const auto next = walk.next();
    ASSERT_TRUE(next.ok() && next->has_value());
    const auto type = DataTypeEntry::decode(**next);
    ASSERT_TRUE(type.ok()) << type.fault().text;
    members += type->members;
  }
  EXPECT_EQ(members, 16U + 29U);
}

TEST(WinchDevice, DescribesAStructMemberByMember) {
  Client client;
  const V bytes = client.read_write(0xF011, 0, 0xFFFFFFFF, as_bytes("st_winchcommand"));
  const auto type = DataTypeEntry::decode(bytes);
  ASSERT_TRUE(type.ok());
  EXPECT_EQ(type->size, 64U);
  EXPECT_EQ(type->members, 16U);
  EntryReader members{type->member_entries};
  for (const auto& member : command_members()) {
    const auto next = members.next();
    ASSERT_TRUE(next.ok() && next->has_value());
    const auto entry = DataTypeEntry::decode(**next);
    ASSERT_TRUE(entry.ok());
    EXPECT_EQ(entry->name, member.name);
    EXPECT_EQ(entry->offset, member.offset);
    EXPECT_EQ(entry->size, member.size);
  }
  (void)client.read_write(0xF011, 0, 0xFFFFFFFF, as_bytes("LREAL"));
  EXPECT_EQ(client.result, 0x710U) << "elementary types need no entry";
}

TEST(WinchDevice, ServesSumsOfReadWritesOfReadsWithLengthsAndOfSubscriptions) {
  Client client;
  std::array<std::uint8_t, 256> buffer{};
  LittleWriter names{buffer};
  SumReadWriteItem{0xF003, 0, 4, 13}.encode(names);
  SumReadWriteItem{0xF007, 0, 12, 18}.encode(names);
  SumReadWriteItem{0xF080, 0, 12, 0}.encode(names);
  names.write_bytes(as_bytes("MAIN.winch.xx"));
  names.write_bytes(as_bytes("GVL_Winch.stStatus"));
  EXPECT_EQ(
      client.read_write(0xF082, 3, 100, names.written()),
      (V{0x10, 7,    0, 0, 0,  0, 0, 0, 0,   0, 0, 0, 12, 0, 0, 0, 2, 7, 0, 0, 0, 0, 0, 0,  // three results
         0x40, 0x40, 0, 0, 64, 0, 0, 0, 120, 0, 0, 0}));
  const auto status = client.handle("GVL_Winch.stStatus");
  LittleWriter reads{buffer};
  SumItem{0xF005, 0xDEAD, 4}.encode(reads);
  SumItem{0xF005, status, 4}.encode(reads);
  const V keeps = client.read_write(0xF083, 2, 100, reads.written());
  EXPECT_EQ(keeps, (V{3, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0}));
  const V packed = client.read_write(0xF084, 2, 100, reads.written());
  EXPECT_EQ(packed, (V{3, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 0, 0, 0, 1, 0, 0, 0}));
  LittleWriter subscribes{buffer};
  AddNotificationRequest{0xF005, status, 120, 3, 0ms, 10ms}.encode(subscribes);
  AddNotificationRequest{0xF005, 0xDEAD, 4, 3, 0ms, 10ms}.encode(subscribes);
  const V handles = client.read_write(0xF085, 2, 16, subscribes.written());
  EXPECT_EQ(handles, (V{0, 0, 0, 0, 1, 0, 0, 0, 3, 7, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(client.bodies.size(), 2U) << "the first sample follows";
  EXPECT_EQ(client.read_write(0xF086, 2, 8, V{1, 0, 0, 0, 9, 0, 0, 0}), (V{0, 0, 0, 0, 0x14, 7, 0, 0}));
  EXPECT_EQ(client.dut.subscriptions(), 0U);
}

TEST(WinchDevice, WithoutGvlWinchObeysTheLaboratorysOwnVariables) {
  DeviceConfig config;
  config.project = PlcProject::legacy;
  Client client{config};
  EXPECT_EQ(client.handle("GVL_Winch.stStatus"), 0U);
  const auto speed = client.handle("MAIN.winch.u");
  const auto enable = client.handle("MAIN.winch.bEnable");
  const auto mode = client.handle("MAIN.winch.eModeCmd");
  std::array<std::uint8_t, 8> value{};
  store<std::endian::little>(value, 0.1);
  double length = 2.0;
  const auto run = [&](int cycles) {
    for (int i = 0; i < cycles; ++i) {
      if (!client.dut.brake_closed()) length = client.dut.set_point_m();
      client.dut.cycle(client.t += 5ms, {length, 0.0, 0.0, 40.0});
    }
  };
  run(10);
  EXPECT_EQ(client.write(0xF005, enable, V{1}), 0U);
  EXPECT_EQ(client.write(0xF005, mode, V{1}), 0U);
  run(100);
  EXPECT_EQ(client.write(0xF005, speed, value), 0U);
  run(400);
  EXPECT_NEAR(length, 2.2, 0.01) << "2 s at 0.1 m/s, and nobody wrote again: it has no watchdog";
  EXPECT_EQ(client.write(0xF005, mode, V{0}), 0U);
  const V told = client.read(0xF005, client.handle("MAIN.winch.length"), 8);
  EXPECT_NEAR((load<double, std::endian::little>(told)), length - 1.2, 1e-9);
}

}  // namespace
}  // namespace motionlab::winch
