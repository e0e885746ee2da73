// The lists of bodies. The first document was accepted by the vendor's C++ and Python clients.
#include <gtest/gtest.h>
#include <tinyxml2.h>

#include "drivers/core/random.hpp"
#include "drivers/qualisys/qualisys_wire_data.hpp"
#include "drivers/qualisys/qualisys_wire_text.hpp"
#include "drivers/qualisys/qualisys_wire_xml.hpp"

namespace motionlab::qualisys {
namespace {

constexpr std::string_view kExample = R"(<QTM_Parameters_Ver_1.25>
    <The_6D>
        <Body>
            <Name>Load</Name>
            <Enabled>true</Enabled>
            <Color R="230" G="90" B="20"/>
            <MaximumResidual>10.000000</MaximumResidual>
            <MinimumMarkersInBody>3</MinimumMarkersInBody>
            <BoneLengthTolerance>5.000000</BoneLengthTolerance>
            <Filter Preset="No filter"/>
            <Points>
                <Point X="250.000000" Y="0.000000" Z="0.000000" Virtual="0" PhysicalId="0" Name="Load - 1"/>
                <Point X="0.000000" Y="250.000000" Z="0.000000" Virtual="0" PhysicalId="0" Name="Load - 2"/>
                <Point X="-250.000000" Y="0.000000" Z="40.000000" Virtual="0" PhysicalId="0" Name="Load - 3"/>
            </Points>
            <Data_origin X="0.000000" Y="0.000000" Z="0.000000" Relative_body="1">0</Data_origin>
            <Data_orientation R11="1.000000" R12="0.000000" R13="0.000000" R21="0.000000" R22="1.000000" R23="0.000000" R31="0.000000" R32="0.000000" R33="1.000000" Relative_body="1">0</Data_orientation>
        </Body>
    </The_6D>
</QTM_Parameters_Ver_1.25>
)";

const std::vector<BodyDefinition> kTwo = {{"Load", true}, {"Platform <1> & \"2\"", false}};

TEST(QualisysXml, ReadsTheExampleThatVendorClientsAccept) {
  const auto bodies = parse_bodies_xml(kExample);
  ASSERT_TRUE(bodies);
  EXPECT_EQ(*bodies, (std::vector<BodyDefinition>{{"Load", true}}));
}

TEST(QualisysXml, WritesTheExampleThatVendorClientsAccept) {
  const std::vector<BodyDefinition> one = {{"Load", true}};
  EXPECT_EQ(write_parameters_xml({.version_minor = 25, .bodies = true, .body_list = one}), kExample);
}

TEST(QualisysXml, ReadsOnlyNamesAndEnabledAndKeepsTheSlotOfABodyWithoutName) {
  const auto bodies = parse_bodies_xml(
      "<?xml version=\"1.0\"?>\r\n<QTM_Parameters_Ver_1.28><General/><The_6D><Future/>"
      "<Body><Enabled>False</Enabled><Name>a&amp;b</Name></Body><Body/>"
      "<Body><Name>c</Name><More><Name>not this</Name></More></Body></The_6D></QTM_Parameters_Ver_1.28>");
  ASSERT_TRUE(bodies);
  EXPECT_EQ(*bodies, (std::vector<BodyDefinition>{{"a&b", false}, {"", true}, {"c", true}}));
}

TEST(QualisysXml, ReadsTheLayoutFromBefore121) {
  const auto bodies = parse_bodies_xml(
      "<QTM_Parameters_Ver_1.19><The_6D><Bodies>1</Bodies><Body><Name>Load</Name><RGBColor>1</RGBColor>"
      "</Body><Euler><First>Roll</First></Euler></The_6D></QTM_Parameters_Ver_1.19>");
  ASSERT_TRUE(bodies);
  EXPECT_EQ(*bodies, (std::vector<BodyDefinition>{{"Load", true}}));
}

TEST(QualisysXml, HasNoBodiesWithoutTheirGroup) {
  EXPECT_TRUE(parse_bodies_xml("<QTM_Parameters_Ver_1.25/>")->empty());
}

TEST(QualisysXml, RefusesWhatIsNoListOfBodies) {
  for (const std::string_view text : {"", "hello", "<a", "<Other/>", "<QTM_Parameters_Ver_1.25><The_6D>"})
    EXPECT_EQ(parse_bodies_xml(text).fault().reason, Reason::bad_header) << text;
}

TEST(QualisysXml, RefusesMoreBodiesThanAFrameCanHold) {
  const std::vector<BodyDefinition> many(kMaxBodies + 1, {"x", true});
  const auto fits = write_parameters_xml({.bodies = true, .body_list = std::span{many}.first(kMaxBodies)});
  EXPECT_EQ(parse_bodies_xml(fits)->size(), kMaxBodies);
  const auto overflows = write_parameters_xml({.bodies = true, .body_list = many});
  EXPECT_EQ(parse_bodies_xml(overflows).fault().reason, Reason::too_long);
}

TEST(QualisysXml, ReadsBackWhatItWritesInEveryVersion) {
  for (int version = 8; version <= 28; ++version) {
    const auto xml =
        write_parameters_xml({.version_minor = version, .general = true, .bodies = true, .body_list = kTwo});
    EXPECT_TRUE(xml.starts_with("<QTM_Parameters_Ver_1." + std::to_string(version) + ">"));
    const auto bodies = parse_bodies_xml(xml);
    ASSERT_TRUE(bodies);
    ASSERT_EQ(bodies->size(), 2u);
    EXPECT_EQ((*bodies)[1].name, kTwo[1].name);
    EXPECT_EQ((*bodies)[1].enabled, version < 24) << "the flag came with 1.24";
  }
}

TEST(QualisysXml, WritesTheCountOfBodiesAndEulerNamesOnlyWhereTheLayoutHasThem) {
  tinyxml2::XMLDocument document;
  const auto group = [&](int version) {
    document.Parse(
        write_parameters_xml({.version_minor = version, .bodies = true, .body_list = kTwo}).c_str());
    return document.RootElement()->FirstChildElement("The_6D");
  };
  EXPECT_STREQ(group(20)->FirstChildElement("Bodies")->GetText(), "2");
  EXPECT_NE(group(16)->FirstChildElement("Euler"), nullptr);
  EXPECT_EQ(group(15)->FirstChildElement("Euler"), nullptr);
  EXPECT_EQ(group(21)->FirstChildElement("Bodies"), nullptr);
  EXPECT_EQ(group(21)->FirstChildElement("Euler"), nullptr);
}

TEST(QualisysXml, WritesAGeneralGroupWithAllThatTheVendorClientReads) {
  tinyxml2::XMLDocument document;
  document.Parse(write_parameters_xml({.rate_hz = 200.0, .general = true}).c_str());
  const auto* general = document.RootElement()->FirstChildElement("General");
  ASSERT_NE(general, nullptr);
  EXPECT_STREQ(general->FirstChildElement("Frequency")->GetText(), "200");
  for (const char* name : {"Capture_Time", "Start_On_External_Trigger", "Start_On_Trigger_NO",
                           "Start_On_Trigger_NC", "Start_On_Trigger_Software", "External_Time_Base",
                           "Processing_Actions", "RealTime_Processing_Actions", "Reprocessing_Actions"})
    EXPECT_NE(general->FirstChildElement(name), nullptr) << name;
}

TEST(QualisysXml, ComparesNamesWithoutCase) {
  EXPECT_TRUE(same_name("Load", "lOAD"));
  EXPECT_FALSE(same_name("Load", "Loads"));
  EXPECT_FALSE(same_name("Load", "Lord"));
}

TEST(QualisysXml, SurvivesRandomChangesOfTheExample) {
  Random random{17};
  for (int round = 0; round < 3000; ++round) {
    std::string xml{
        kExample.substr(0, 200 + random.below(static_cast<std::uint32_t>(kExample.size() - 200)))};
    for (int change = 0; change < 5; ++change)
      xml[random.below(static_cast<std::uint32_t>(xml.size()))] = "<>/&;\" \0x"[random.below(9)];
    const auto bodies = parse_bodies_xml(xml);
    if (bodies) {
      EXPECT_LE(bodies->size(), kMaxBodies);
    }
  }
}

}  // namespace
}  // namespace motionlab::qualisys
