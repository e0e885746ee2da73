// What the doctor makes of a machine.
#include "gateway/doctor/machine.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/doctor/find.hpp"

namespace motionlab::doctor {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Machine a_good_one() {
  Machine machine;
  machine.kernel = "6.1.0-rt";
  machine.preempt_rt = true;
  machine.processors = 4;
  machine.isolated = {2, 3};
  machine.governors = {"performance", "performance", "performance", "performance"};
  machine.wakes_after_us = 2;
  machine.grants_fifo = machine.grants_lock = true;
  machine.clock_source = "tsc";
  machine.clock_disciplined = true;
  machine.clock_error_s = 5e-5;
  machine.recordings = "/var/lib/motionlab";
  machine.recordings_free_bytes = 200'000'000'000;
  return machine;
}

service::GatewayConfig with_own_processors() {
  service::GatewayConfig config;
  config.control_cpu = 3;
  config.io_cpu = 2;
  return config;
}

TEST(DoctorsMachine, ThatIsAsItShouldBePasses) {
  const Findings findings = judge(a_good_one(), with_own_processors());
  EXPECT_EQ(worst(findings), Grade::pass);
  for (const Finding& finding : findings) EXPECT_THAT(finding.fix, IsEmpty()) << finding.subject;
}

TEST(DoctorsMachine, ThatIsNotIsToldWhatItLacksAndHowToGetIt) {
  struct Case {
    std::string subject, words;
    Grade grade;
    std::function<void(Machine&)> spoil;
  };
  const std::vector<Case> cases{
      {"kernel", "no real-time kernel", Grade::warn, [](Machine& m) { m.preempt_rt = false; }},
      {"scheduling", "SCHED_FIFO", Grade::warn, [](Machine& m) { m.grants_fifo = false; }},
      {"memory", "cannot lock", Grade::warn, [](Machine& m) { m.grants_lock = false; }},
      {"governor", "powersave", Grade::warn, [](Machine& m) { m.governors[2] = "powersave"; }},
      {"sleep", "a virtual machine", Grade::warn, [](Machine& m) { m.is_virtual = true; }},
      {"sleep", "needs 170 us", Grade::warn, [](Machine& m) { m.wakes_after_us = 170; }},
      {"[control] cpu", "processor 3 is not here", Grade::fail, [](Machine& m) { m.processors = 3; }},
      {"[control] io_cpu", "shared with other programs; isolated: 3", Grade::warn,
       [](Machine& m) { m.isolated = {3}; }},
      {"clock", "nobody disciplines", Grade::warn, [](Machine& m) { m.clock_disciplined = false; }},
      {"clock", "within 20.0 ms", Grade::warn, [](Machine& m) { m.clock_error_s = 0.02; }},
      {"shared memory", "3 files of DDS programs, 12 MB", Grade::warn,
       [](Machine& m) { m.shared_files = 3, m.shared_bytes = 12'000'000; }},
      {"disk", "1.5 GB are free", Grade::warn, [](Machine& m) { m.recordings_free_bytes = 1'500'000'000; }},
      {"disk", "there is no folder /var/lib/motionlab", Grade::fail,
       [](Machine& m) { m.recordings_free_bytes.reset(); }},
  };
  for (const Case& each : cases) {
    Machine machine = a_good_one();
    each.spoil(machine);
    const Findings findings = judge(machine, with_own_processors());
    const Finding* const found = find(findings, each.subject);
    ASSERT_TRUE(found) << each.subject;
    EXPECT_EQ(found->grade, each.grade) << each.subject;
    EXPECT_THAT(found->text, HasSubstr(each.words));
    EXPECT_FALSE(found->fix.empty()) << each.subject;
    EXPECT_EQ(worst(findings), each.grade);
  }
}

TEST(DoctorsMachine, ThatSleepsDoesNotMatterToAProcessorThatIsKeptAwake) {
  Machine machine = a_good_one();
  machine.is_virtual = true;
  machine.wakes_after_us = 170;
  auto config = with_own_processors();
  config.control_awake = true;
  EXPECT_EQ(worst(judge(machine, config)), Grade::pass);
}

TEST(DoctorsMachine, WithoutAChoiceOfProcessorsIsNotAskedForAny) {
  const Findings findings = judge(a_good_one(), {});
  EXPECT_FALSE(find(findings, "[control] cpu"));
}

TEST(DoctorsMachine, IsReadFromThisKernel) {
  service::GatewayConfig config;
  config.record.inputs = testing::TempDir() + "/run.mcap";
  const Machine machine = look_at_machine(config);
  EXPECT_FALSE(machine.kernel.empty());
  EXPECT_GE(machine.processors, 1);
  EXPECT_FALSE(machine.clock_source.empty());
  EXPECT_GT(machine.recordings_free_bytes.value_or(0), 0U);
  config.record.inputs = "/no/such/folder/run.mcap";
  EXPECT_FALSE(look_at_machine(config).recordings_free_bytes);
}

TEST(ProcessorList, IsReadAsTheKernelWritesIt) {
  EXPECT_THAT(processor_list(""), IsEmpty());
  EXPECT_THAT(processor_list("3"), ElementsAre(3));
  EXPECT_THAT(processor_list("0-2,5,7-8"), ElementsAre(0, 1, 2, 5, 7, 8));
  EXPECT_THAT(processor_list("1-"), IsEmpty());
  EXPECT_THAT(processor_list("two"), IsEmpty());
  EXPECT_THAT(processor_list("1;2"), IsEmpty());
}

}  // namespace
}  // namespace motionlab::doctor
