#include "gateway/monitor/sample_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "drivers/core/error.hpp"
#include "gateway/monitor/topic_json.hpp"
#include "idl/bodies.hpp"
#include "idl/event.hpp"
#include "idl/mru.hpp"

namespace motionlab::monitor {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

topic::Mru mru() {
  topic::Mru sample;
  sample.device = "mru1";
  sample.sequence_number = 18446744073709551615u;
  sample.t_measured_ns = 1'795'551'348'123'456'789;
  sample.stable = true;
  sample.euler_heading_mru_rad = {0.1, -1.0 / 3.0, 1e-300};
  return sample;
}

const TopicDescription& of_mru() {
  return *topic_named("motionlab/mru");
}

template <class F>
std::string why(F&& f) {
  try {
    f();
  } catch (const StartupError& error) {
    return error.what();
  }
  return "";
}

TEST(TopicTable, DescribesEveryTopicOfTheVocabulary) {
  std::size_t count = 0;
#define MOTIONLAB_LOOK(Type)                                                       \
  ++count;                                                                         \
  {                                                                                \
    const TopicDescription* const topic = topic_of_type(topic::Type::kTypeName);   \
    ASSERT_NE(topic, nullptr);                                                     \
    EXPECT_EQ(topic_named(topic->name), topic);                                    \
    EXPECT_EQ(values_of(topic::Type{}).size(), topic->value_count) << topic->name; \
    EXPECT_EQ(topic_json(topic::Type{}).size(), topic->fields.size());             \
  }
  MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_LOOK)
#undef MOTIONLAB_LOOK
  EXPECT_EQ(every_topic().size(), count);
}

TEST(TopicTable, NamesInstancesByTheirKeys) {
  topic::Bodies body;
  body.device = "qualisys";
  body.body = "load";
  EXPECT_EQ(instance_of(body), "qualisys/load");
  EXPECT_EQ(instance_of(topic::Event{}), "");
}

TEST(TopicTable, TakesOnlyPossibleStamps) {
  topic::Mru sample = mru();
  EXPECT_EQ(stamp_in(of_mru(), values_of(sample), "t_measured_ns"), 1'795'551'348'123'456'789);
  EXPECT_EQ(stamp_in(of_mru(), values_of(sample), "device"), std::nullopt);
  EXPECT_EQ(stamp_in(of_mru(), values_of(sample), "t_nothing_ns"), std::nullopt);
  for (const std::int64_t impossible : {std::numeric_limits<std::int64_t>::min(), std::int64_t{-1},
                                        std::numeric_limits<std::int64_t>::max()}) {
    sample.t_measured_ns = impossible;
    EXPECT_EQ(stamp_in(of_mru(), values_of(sample), "t_measured_ns"), std::nullopt);
  }
}

TEST(FieldSelection, FindsFieldsArraysAndElementsInTheOrderAskedFor) {
  const auto fields =
      select_fields(of_mru(), {"euler_heading_mru_rad[1]", "stable", "euler_heading_mru_rad"});
  ASSERT_EQ(fields.size(), 3u);
  EXPECT_EQ(
      as_line(fields, values_of(mru())),
      "euler_heading_mru_rad[1] -0.333333  stable true  euler_heading_mru_rad [0.1, -0.333333, 1e-300]\n");
}

TEST(FieldSelection, NamesTheNearestFieldWhenThereIsNone) {
  const std::string error = why([] { (void)select_fields(of_mru(), {"sequence_numbr"}); });
  EXPECT_THAT(error, HasSubstr("no field sequence_numbr in motionlab/mru; do you mean sequence_number?"));
  EXPECT_THAT(why([] { (void)select_fields(of_mru(), {"a.b[2]"}); }),
              HasSubstr("no field a.b in motionlab/mru"));
  EXPECT_THAT(why([] { (void)select_fields(of_mru(), {"\033[2J"}); }), HasSubstr("no field \\x1b in"));
}

TEST(FieldSelection, SaysHowLongAnArrayIs) {
  for (const char* const wrong : {"omega_mru_radps[3]", "omega_mru_radps[99999]"}) {
    EXPECT_THAT(why([wrong] { (void)select_fields(of_mru(), {wrong}); }),
                HasSubstr("the elements [0] to [2]"));
  }
  for (const char* const wrong :
       {"omega_mru_radps[]", "omega_mru_radps[-1]", "omega_mru_radps[1", "omega_mru_radps[1]x",
        "omega_mru_radps[x]", "omega_mru_radps[1][2]", "omega_mru_radps[99999999999999999999999]"}) {
    EXPECT_THAT(why([wrong] { (void)select_fields(of_mru(), {wrong}); }), HasSubstr("omega_mru_radps[2]"))
        << wrong;
  }
  EXPECT_THAT(why([] { (void)select_fields(of_mru(), {"stable[0]"}); }), HasSubstr("a single value"));
}

TEST(SampleText, IsABlockWithTheTimeOfDay) {
  const std::string text = as_block(select_fields(of_mru(), {}), values_of(mru()));
  EXPECT_THAT(text, StartsWith("device                   mru1\n"));
  EXPECT_THAT(text, HasSubstr("\nt_measured_ns            1795551348123456789  (20:15:48.123456 UTC)\n"));
  EXPECT_THAT(text, HasSubstr("\nt_received_ns            0\n"));
  EXPECT_THAT(text, HasSubstr("\neuler_heading_mru_rad    [0.1, -0.333333, 1e-300]\n"));
  EXPECT_THAT(text, testing::EndsWith("\n---\n"));
}

TEST(SampleText, LetsNobodyOnTheBusWriteToTheTerminal) {
  topic::Event event;
  event.severity = topic::Severity::warning;
  event.text = "\033[31mred\nsecond, \"line\"";
  const auto fields = select_fields(*topic_named("motionlab/event"), {"severity", "text"});
  const Values values = values_of(event);
  EXPECT_EQ(as_line(fields, values), "severity warning  text \\x1b[31mred\\nsecond, \"line\"\n");
  EXPECT_EQ(as_json_line(fields, values),
            "{\"severity\":\"warning\",\"text\":\"\\u001b[31mred\\nsecond, \\\"line\\\"\"}\n");
  EXPECT_EQ(as_csv(fields, values), "warning,\"\\x1b[31mred\\nsecond, \"\"line\"\"\"\n");
}

TEST(SampleJson, KeepsEveryDigitAndIsOneLineOfAscii) {
  topic::Mru sample = mru();
  sample.device = "\xffÅ\u009b";
  const std::string line = as_json_line(select_fields(of_mru(), {}), values_of(sample));
  const auto json = nlohmann::json::parse(line);
  EXPECT_EQ(json["sequence_number"].get<std::uint64_t>(), sample.sequence_number);
  EXPECT_EQ(json["t_measured_ns"].get<std::int64_t>(), sample.t_measured_ns);
  EXPECT_EQ((json["euler_heading_mru_rad"].get<std::array<double, 3>>()), sample.euler_heading_mru_rad);
  EXPECT_EQ(json["stable"], true);
  EXPECT_EQ(line.find('\n'), line.size() - 1);
  for (const char character : line) EXPECT_TRUE(character == '\n' || (character >= 0x20 && character < 0x7F));
}

TEST(SampleJson, SaysNullForWhatIsNotFinite) {
  topic::Mru sample = mru();
  sample.euler_heading_mru_rad = {std::numeric_limits<double>::quiet_NaN(), 0, 0};
  EXPECT_EQ(as_json_line(select_fields(of_mru(), {"euler_heading_mru_rad"}), values_of(sample)),
            "{\"euler_heading_mru_rad\":[null,0.0,0.0]}\n");
}

TEST(SampleCsv, HasAColumnForEachElementAndKeepsEveryDigit) {
  const auto fields =
      select_fields(of_mru(), {"device", "sequence_number", "euler_heading_mru_rad", "stable"});
  EXPECT_EQ(csv_header(fields),
            "device,sequence_number,euler_heading_mru_rad[0],euler_heading_mru_rad[1],euler_heading_mru_rad["
            "2],stable\n");
  EXPECT_EQ(as_csv(fields, values_of(mru())), "mru1,18446744073709551615,0.1,-0.3333333333333333,1e-300,1\n");
  topic::Mru sample = mru();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  sample.euler_heading_mru_rad = {std::numeric_limits<double>::quiet_NaN(), kInfinity, -kInfinity};
  EXPECT_EQ(as_csv(select_fields(of_mru(), {"euler_heading_mru_rad"}), values_of(sample)), "NaN,Inf,-Inf\n");
}

TEST(SampleCsv, HasAsManyCellsAsItsHeaderForEveryTopic) {
#define MOTIONLAB_LOOK(Type)                                                                               \
  {                                                                                                        \
    const auto fields = select_fields(*topic_of_type(topic::Type::kTypeName), {});                         \
    const auto commas = [](const std::string& line) { return std::count(line.begin(), line.end(), ','); }; \
    EXPECT_EQ(commas(csv_header(fields)), commas(as_csv(fields, values_of(topic::Type{}))));               \
  }
  MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_LOOK)
#undef MOTIONLAB_LOOK
}

}  // namespace
}  // namespace motionlab::monitor
