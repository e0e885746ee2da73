// The commands as a server reads them. Texts are those of the published documentation and of other clients.
#include "drivers/qualisys/qualisys_wire_command.hpp"

#include <gtest/gtest.h>

namespace motionlab::qualisys {
namespace {

template <class T>
T read(std::string_view text) {
  const auto parsed = parse_command(text);
  EXPECT_TRUE(parsed) << text;
  const T* found = parsed ? std::get_if<T>(&*parsed) : nullptr;
  EXPECT_NE(found, nullptr) << text;
  return found != nullptr ? *found : T{};
}

TEST(QualisysCommand, ReadsVersionsAndLeavesToTheServerWhichItSpeaks) {
  EXPECT_FALSE(read<command::Version>("Version").minor);
  EXPECT_EQ(read<command::Version>("version 1.25").minor, 25);
  for (const char* text :
       {"Version 2.0", "Version x", "Version 1.", "Version 1.2x", "Version 1.-5", "Version 1.2 3"})
    EXPECT_EQ(read<command::Version>(text).minor, -1) << text;
}

TEST(QualisysCommand, ReadsStreamsAsOtherClientsAskForThem) {
  const auto vendor = read<command::StreamFrames>("StreamFrames AllFrames UDP:6734 6D ");
  EXPECT_EQ(vendor.divisor, 1u);
  EXPECT_EQ(vendor.udp->address, 0u);
  EXPECT_EQ(vendor.udp->port, 6734);
  EXPECT_EQ(vendor.components, Components{Component::bodies});
  const auto python = read<command::StreamFrames>("streamframes allframes 6d");
  EXPECT_FALSE(python.udp);
  const auto fork = read<command::StreamFrames>("StreamFrames AllFrames UDP:6734 3DNoLabels 6DEuler ");
  EXPECT_EQ(fork.components, (Components{Component::unlabelled, Component::angles}));
  const auto slow =
      read<command::StreamFrames>("StreamFrames Frequency:100 UDP:192.0.2.10:14570 3D Analog:1,2");
  EXPECT_EQ(slow.rate_hz, 100.0);
  EXPECT_EQ(slow.udp->address, 0xC000020Au);
  EXPECT_EQ(slow.components, (Components{Component::markers, Component::analog}));
  EXPECT_EQ(read<command::StreamFrames>("StreamFrames FrequencyDivisor:4 Timecode").divisor, 4u);
  read<command::StopStream>("streamframes  STOP ");
}

TEST(QualisysCommand, ReadsControl) {
  EXPECT_EQ(read<command::TakeControl>("takecontrol ").password, "");
  EXPECT_EQ(read<command::TakeControl>("TakeControl open sesame").password, "open sesame");
  EXPECT_TRUE(read<command::Start>("Start rtfromfile").from_file);
  EXPECT_FALSE(read<command::Start>("start").from_file);
  EXPECT_EQ(read<command::SetEvent>("SetQTMEvent load lifted ").label, "load lifted");
  EXPECT_EQ(read<command::SetEvent>("event lift").label, "lift");
  read<command::GetState>("GetLastEvent");
}

TEST(QualisysCommand, ReadsGroupsOfParameters) {
  EXPECT_EQ(read<command::GetParameters>("GetParameters All").groups, (ParameterGroups{true, true, true}));
  EXPECT_EQ(read<command::GetParameters>("getparameters 6d general").groups,
            (ParameterGroups{true, true, false}));
  EXPECT_EQ(read<command::GetParameters>("GetParameters Skeleton:global").groups, ParameterGroups{});
}

TEST(QualisysCommand, RefusesTheRest) {
  for (const char* text : {"",
                           " ",
                           "Hello",
                           "GetState now",
                           "QTMVersion 1",
                           "GetParameters",
                           "GetParameters Weather",
                           "GetCurrentFrame",
                           "GetCurrentFrame 7D",
                           "StreamFrames",
                           "StreamFrames AllFrames",
                           "StreamFrames Sometimes 6D",
                           "StreamFrames AllFrames UDP:6734",
                           "StreamFrames AllFrames UDP:80 6D",
                           "StreamFrames AllFrames UDP:65536 6D",
                           "StreamFrames AllFrames UDP:1.2.3:6734 6D",
                           "StreamFrames AllFrames UDP:1.2.3.4.5:6734 6D",
                           "StreamFrames AllFrames UDP:1.2.3.256:6734 6D",
                           "StreamFrames Frequency:0 6D",
                           "StreamFrames Frequency:nan 6D",
                           "StreamFrames Frequency:inf 6D",
                           "StreamFrames Frequency:-5 6D",
                           "StreamFrames FrequencyDivisor:0 6D",
                           "StreamFrames Stop 6D",
                           "Start now",
                           "Start RTFromFile twice",
                           "New one"})
    EXPECT_EQ(parse_command(text).fault().reason, Reason::refused) << text;
}

TEST(QualisysCommand, KnowsEveryComponentByItsWordAndBack) {
  for (const ComponentWord& entry : kComponentWords) {
    EXPECT_EQ(component_of(entry.word), entry.component);
    EXPECT_EQ(word_of(entry.component), entry.word);
  }
  EXPECT_FALSE(component_of("3DNoLabelsResidual"));
}

}  // namespace
}  // namespace motionlab::qualisys
