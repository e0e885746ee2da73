// What threads ask of the kernel, where every kernel grants it.
#include "gateway/service/real_time.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <thread>

namespace motionlab::service {
namespace {

using testing::HasSubstr;
using namespace std::chrono_literals;

/// Of a thread; 0: of the calling one.
cpu_set_t processors_of(pid_t thread) {
  cpu_set_t processors;
  CPU_ZERO(&processors);
  sched_getaffinity(thread, sizeof processors, &processors);
  return processors;
}

int first_of(const cpu_set_t& processors) {
  int cpu = 0;
  while (cpu < CPU_SETSIZE && !CPU_ISSET(static_cast<std::size_t>(cpu), &processors)) ++cpu;
  return cpu;
}

/// The thread of this process that has this name.
std::optional<pid_t> thread_named(const std::string& wanted) {
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::ifstream file(task.path() / "comm");
    if (std::string name; file >> name && name == wanted) return std::stoi(task.path().filename());
  }
  return std::nullopt;
}

TEST(AwakeProcessor, IsTurnedOnByAThreadThatYieldsToEverybody) {
  const int cpu = first_of(processors_of(0));
  {
    const AwakeProcessor dut(cpu);
    EXPECT_EQ(dut.refused(), "");
    const auto thread = thread_named("awake");
    ASSERT_TRUE(thread);
    EXPECT_EQ(sched_getscheduler(*thread), SCHED_IDLE);
    const cpu_set_t its = processors_of(*thread);
    EXPECT_EQ(CPU_COUNT(&its), 1);
    EXPECT_EQ(first_of(its), cpu);
  }
  // The kernel's list keeps a thread that was joined for a moment.
  for (int i = 0; i < 5000 && thread_named("awake"); ++i) std::this_thread::sleep_for(1ms);
  EXPECT_FALSE(thread_named("awake"));
}

TEST(AwakeProcessor, ThatIsNotHereIsNamed) {
  EXPECT_THAT(AwakeProcessor(CPU_SETSIZE - 1).refused(), HasSubstr("processor 1023"));
}

TEST(AProcessorThatIsLeft, IsNotThatOfLaterThreads) {
  const cpu_set_t before = processors_of(0);
  if (CPU_COUNT(&before) < 2) GTEST_SKIP() << "this machine has one processor";
  const int left = first_of(before);
  std::thread([&] {
    leave_processor(left);
    std::thread([&] {
      const cpu_set_t ours = processors_of(0);
      EXPECT_FALSE(CPU_ISSET(static_cast<std::size_t>(left), &ours));
      EXPECT_EQ(CPU_COUNT(&ours), CPU_COUNT(&before) - 1);
    }).join();
  }).join();
}

TEST(AProcessorThatIsLeft, IsKeptIfThereIsNoOther) {
  std::thread([] {
    cpu_set_t only;
    CPU_ZERO(&only);
    const int cpu = first_of(processors_of(0));
    CPU_SET(static_cast<std::size_t>(cpu), &only);
    ASSERT_EQ(sched_setaffinity(0, sizeof only, &only), 0);
    for (const int each : {cpu, -1, CPU_SETSIZE}) leave_processor(each);
    const cpu_set_t ours = processors_of(0);
    EXPECT_TRUE(CPU_EQUAL(&ours, &only));
  }).join();
}

}  // namespace
}  // namespace motionlab::service
