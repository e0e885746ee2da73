#include "gateway/console/foxglove.hpp"

#include <gtest/gtest.h>

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>

#include "gateway/bus/topic_list.hpp"
#include "gateway/console/board.hpp"

namespace motionlab::console::foxglove {
namespace {

using nlohmann::json;

template <class Meant>
Meant read_as(const std::string& text) {
  return std::get<Meant>(std::get<ClientText>(read_text(text)));
}

TEST(Foxglove, AdvertisesATopicWithItsIdl) {
  const auto channel = static_cast<std::uint32_t>(bus::topic_index<topic::ModeRequest>()) + 1;
  const json message = json::parse(advertise(std::array{channel, kOwnChannel}));
  EXPECT_EQ(message["op"], "advertise");
  const json& entry = message["channels"][0];
  EXPECT_EQ(entry["id"], channel);
  EXPECT_EQ(entry["topic"], "motionlab/mode_request");
  EXPECT_EQ(entry["encoding"], "cdr");
  EXPECT_EQ(entry["schemaEncoding"], "omgidl");
  EXPECT_EQ(entry["schemaName"], "motionlab::ModeRequest");
  const auto schema = entry["schema"].get<std::string>();
  EXPECT_EQ(schema.find("#include"), std::string::npos);
  EXPECT_NE(schema.find("enum Authority"), std::string::npos) << "of the included file";
  EXPECT_EQ(message["channels"][1]["topic"], "console/state");
}

TEST(Foxglove, OffersPublishingOnlyWithControl) {
  EXPECT_TRUE(json::parse(server_info(false, "1"))["capabilities"].empty());
  EXPECT_EQ(json::parse(server_info(true, "1"))["capabilities"], json::array({"clientPublish"}));
}

TEST(Foxglove, WritesTheHeaderOfTheSpecification) {
  const Header header = message_header(0x01020304, 0x1112131415161718);
  const Header wanted{1, 4, 3, 2, 1, 0x18, 0x17, 0x16, 0x15, 0x14, 0x13, 0x12, 0x11};
  EXPECT_EQ(header, wanted);
}

TEST(Foxglove, ReadsWhatClientsSay) {
  const auto subscribe = read_as<Subscribe>(
      R"({"op":"subscribe","subscriptions":[{"id":3,"channelId":5},{"id":4294967295,"channelId":6}]})");
  ASSERT_EQ(subscribe.all.size(), 2U);
  EXPECT_EQ(subscribe.all[0].subscription, 3U);
  EXPECT_EQ(subscribe.all[0].channel, 5U);
  EXPECT_EQ(subscribe.all[1].subscription, 4294967295U);
  EXPECT_EQ(read_as<Unsubscribe>(R"({"op":"unsubscribe","subscriptionIds":[1,2]})").subscriptions.size(), 2U);
  const auto advertised = read_as<Advertise>(
      R"({"op":"advertise","channels":[{"id":1,"topic":"t","encoding":"json","schemaName":"s"}]})");
  EXPECT_EQ(advertised.all.at(0).topic, "t");
  EXPECT_EQ(read_as<Unadvertise>(R"({"op":"unadvertise","channelIds":[9]})").channels.at(0), 9U);
  EXPECT_EQ(read_as<Authorize>(R"({"op":"motionlab/authorize","token":"x"})").token, "x");
}

TEST(Foxglove, RefusesWhatIsNoMessage) {
  for (const char* text :
       {"", "{", "[]", "7", "null", R"({"op":7})", R"({"op":"subscribe"})",
        R"({"op":"subscribe","subscriptions":7})",
        R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]})",
        R"({"op":"subscribe","subscriptions":[{"id":4294967296,"channelId":1}]})",
        R"({"op":"subscribe","subscriptions":[{"id":1.5,"channelId":1}]})", R"({"op":"getParameters"})",
        R"({"op":"motionlab/authorize","token":7})", "\xff\xfe"}) {
    EXPECT_TRUE(std::holds_alternative<std::string>(read_text(text))) << text;
  }
  json many{{"op", "unsubscribe"}, {"subscriptionIds", json::array()}};
  for (int i = 0; i < 300; ++i) many["subscriptionIds"].push_back(i);
  EXPECT_TRUE(std::holds_alternative<std::string>(read_text(many.dump())));
}

TEST(Foxglove, ReadsTheClientsOwnMessages) {
  const std::string bytes{"\x01\x07\x00\x00\x01{}", 7};
  const auto message = std::get<ClientMessage>(read_binary(bytes));
  EXPECT_EQ(message.channel, 0x01000007U);
  EXPECT_EQ(message.payload, "{}");
  for (const std::string& wrong :
       {std::string{}, std::string{"\x01\x07\x00\x00", 4}, std::string{"\x02\x07\x00\x00\x00", 5}}) {
    EXPECT_TRUE(std::holds_alternative<std::string>(read_binary(wrong)));
  }
}

}  // namespace
}  // namespace motionlab::console::foxglove
