#include "gateway/console/json_sample.hpp"

#include <gtest/gtest.h>

#include <string>

#include "idl/mode_request.hpp"
#include "idl/reference.hpp"
#include "idl/winch_state.hpp"

namespace motionlab::console {
namespace {

using nlohmann::json;

template <class T>
std::string refusal(const json& given) {
  T sample;
  try {
    fill_from_json(given, sample);
    return "taken";
  } catch (const std::invalid_argument& wrong) {
    return wrong.what();
  }
}

TEST(JsonSample, FillsTheFieldsThatItNames) {
  topic::Reference reference;
  reference.sequence_number = 7;
  fill_from_json(
      json::parse(R"({"frame":"em1500","p_world_load_m":[1,2.5,-3],"requester":"me","t_created_ns":-5})"),
      reference);
  EXPECT_EQ(reference.frame, topic::ReferenceFrame::em1500);
  EXPECT_EQ(reference.p_world_load_m, (std::array<double, 3>{1, 2.5, -3}));
  EXPECT_EQ(reference.requester.view(), "me");
  EXPECT_EQ(reference.t_created_ns, -5);
  EXPECT_EQ(reference.sequence_number, 7U);
}

TEST(JsonSample, RefusesWhatTheIdlDoesNotHave) {
  EXPECT_NE(refusal<topic::ModeRequest>({{"colour", "red"}}).find("requester"), std::string::npos);
  EXPECT_EQ(refusal<topic::ModeRequest>({{"action", "fly"}}),
            "action is none of settle, engage, reset, authority");
  EXPECT_EQ(refusal<topic::ModeRequest>({{"action", 1}}), "action is no name of a choice");
  EXPECT_EQ(refusal<topic::ModeRequest>({{"requester", std::string(33, 'x')}}),
            "requester has more than 32 characters");
  EXPECT_EQ(refusal<topic::ModeRequest>({{"sequence_number", -1}}), "sequence_number is out of its range");
  EXPECT_EQ(refusal<topic::ModeRequest>({{"sequence_number", 1.5}}), "sequence_number is no whole number");
  EXPECT_EQ(refusal<topic::WinchState>({{"watchdog_trips", 4294967296}}),
            "watchdog_trips is out of its range");
  EXPECT_EQ(refusal<topic::WinchState>({{"watchdog_trips", 4294967295}}), "taken");
  EXPECT_EQ(refusal<topic::WinchState>({{"ready", 1}}), "ready is neither true nor false");
  EXPECT_EQ(refusal<topic::Reference>({{"p_world_load_m", {1, 2}}}), "p_world_load_m is no list of 3");
  EXPECT_EQ(refusal<topic::Reference>({{"p_world_load_m", {1, 2, "x"}}}), "p_world_load_m is no number");
  EXPECT_EQ(refusal<topic::Reference>({{"p_world_load_m", {1, 2, HUGE_VAL}}}),
            "p_world_load_m is not finite");
  EXPECT_EQ(refusal<topic::Reference>(json::array()), "the message is no JSON object");
  EXPECT_EQ(refusal<topic::Reference>(json(json::value_t::discarded)), "the message is no JSON object");
}

}  // namespace
}  // namespace motionlab::console
