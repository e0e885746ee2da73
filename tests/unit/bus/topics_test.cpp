#include "gateway/bus/topics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "tests/unit/bus/samples.hpp"

namespace motionlab::bus {
namespace {

template <class T>
class EveryTopic : public testing::Test {};
TYPED_TEST_SUITE(EveryTopic, AllTopics::Types::Into<testing::Types>);

template <class T>
std::string type_name() {
  return std::string{T::kTypeName.substr(T::kTypeName.rfind(':') + 1)};
}

std::string idl_text(const std::string& type) {
  std::ifstream file{std::string{MOTIONLAB_SOURCE_DIR} + "/idl/" + type + ".idl"};
  EXPECT_TRUE(file.good()) << type;
  return {std::istreambuf_iterator<char>{file}, {}};
}

/// The members of the struct as the .idl file says them; read here, independently of plain.py.
std::vector<std::string> idl_members(const std::string& type) {
  const std::string text = std::regex_replace(idl_text(type), std::regex{"//[^\n]*"}, "");
  std::smatch body;
  EXPECT_TRUE(std::regex_search(text, body, std::regex{"struct\\s+" + type + "\\s*\\{([^}]*)\\}"}));
  const std::string members = body[1];
  std::vector<std::string> names;
  const std::regex member{"(\\w+)\\s*(\\[\\d+\\])?\\s*;"};
  for (std::sregex_iterator it{members.begin(), members.end(), member}, end; it != end; ++it) {
    names.push_back((*it)[1]);
  }
  return names;
}

TYPED_TEST(EveryTopic, HasEveryFieldOfItsIdlFileInOrder) {
  std::vector<std::string> fields;
  const TypeParam sample{};
  TypeParam::fields(sample, [&](std::string_view name, const auto&) { fields.emplace_back(name); });
  EXPECT_EQ(fields, idl_members(type_name<TypeParam>()));
}

TYPED_TEST(EveryTopic, IsFinalAndHasBoundedTextsOnly) {
  const std::string text = idl_text(type_name<TypeParam>());
  EXPECT_TRUE(std::regex_search(text, std::regex{"@final\\s+struct\\s+" + type_name<TypeParam>() + "\\b"}));
  EXPECT_FALSE(std::regex_search(text, std::regex{"\\bstring\\s+\\w"})) << "an unbounded text";
  EXPECT_FALSE(std::regex_search(text, std::regex{"\\bsequence\\b"}));
}

TYPED_TEST(EveryTopic, AllowsNanOnlyInFieldsThatItHas) {
  std::set<std::string_view> fields;
  const TypeParam sample{};
  TypeParam::fields(sample, [&](std::string_view name, const auto&) { fields.insert(name); });
  for (const std::string_view name : TopicTraits<TypeParam>::may_be_nan)
    EXPECT_TRUE(fields.contains(name)) << name;
}

TYPED_TEST(EveryTopic, HasARhythmWhenItIsPacedOrHasADeadline) {
  using Traits = TopicTraits<TypeParam>;
  EXPECT_TRUE(Traits::period_s > 0 || !(Traits::paced || Traits::qos == QosClass::sensor));
  EXPECT_FALSE(Traits::paced && TypeParam::kKeyed) << "the newest of several instances would be one of them";
}

TEST(Topics, HaveTheNamesThatUsersWereTold) {
  std::map<std::string, std::string> names;
#define MOTIONLAB_NAME(Type) names[#Type] = TopicTraits<topic::Type>::name;
  MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_NAME)
#undef MOTIONLAB_NAME
  const std::map<std::string, std::string> told{{"Mru", "motionlab/mru"},
                                                {"Bodies", "motionlab/bodies"},
                                                {"ArmState", "motionlab/arm_state"},
                                                {"ArmCommand", "motionlab/arm_command"},
                                                {"WinchState", "motionlab/winch_state"},
                                                {"WinchCommand", "motionlab/winch_command"},
                                                {"Estimate", "motionlab/estimate"},
                                                {"Control", "motionlab/control"},
                                                {"Reference", "motionlab/reference"},
                                                {"Mode", "motionlab/mode"},
                                                {"Timing", "motionlab/timing"},
                                                {"ModeRequest", "motionlab/mode_request"},
                                                {"Health", "motionlab/health"},
                                                {"Score", "motionlab/score"},
                                                {"Event", "motionlab/event"},
                                                {"TruthWorld", "truth/world"},
                                                {"SimControl", "sim/control"}};
  EXPECT_EQ(names, told);
}

TEST(Topics, OfTheTruthAreInItsPartitionAndNoOthers) {
#define MOTIONLAB_PARTITION(Type)                                      \
  EXPECT_EQ(TopicTraits<topic::Type>::partition == kTruthPartition,    \
            !TopicTraits<topic::Type>::name.starts_with("motionlab/")) \
      << #Type;
  MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_PARTITION)
#undef MOTIONLAB_PARTITION
}

}  // namespace
}  // namespace motionlab::bus
