// The gateway as systemd sees it: ready, status, watchdog, reload. The test stands in for systemd.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/ptrace.h>

#include "tests/integration/notify_socket.hpp"
#include "tests/integration/process_bench.hpp"

namespace motionlab::integration {
namespace {

using testing::HasSubstr;

/// One thread of another process, stopped for as long as this lives.
class StoppedThread {
 public:
  StoppedThread(pid_t process, const std::string& name) {
    const std::filesystem::path tasks = "/proc/" + std::to_string(process) + "/task";
    for (const auto& task : std::filesystem::directory_iterator(tasks)) {
      std::string comm;
      std::getline(std::ifstream(task.path() / "comm"), comm);
      if (comm == name) thread_ = std::stoi(task.path().filename());
    }
    if (thread_ < 0) throw std::runtime_error("no thread " + name);
    if (ptrace(PTRACE_SEIZE, thread_, nullptr, nullptr) != 0 ||
        ptrace(PTRACE_INTERRUPT, thread_, nullptr, nullptr) != 0) {
      throw std::runtime_error("cannot stop the thread " + name);
    }
    int status = 0;
    waitpid(thread_, &status, __WALL);
  }
  ~StoppedThread() { ptrace(PTRACE_DETACH, thread_, nullptr, nullptr); }
  StoppedThread(const StoppedThread&) = delete;
  StoppedThread& operator=(const StoppedThread&) = delete;

 private:
  pid_t thread_ = -1;
};

class Service : public Processes {
 protected:
  bool hears(const std::string& words) {
    return eventually([&] { return systemd_.heard(words); }, kPatience);
  }
  /// Nothing of the kind comes for a while.
  bool hears_no(const std::string& words) {
    return !eventually([&] { return systemd_.heard(words); }, std::chrono::seconds{2});
  }

  NotifySocket systemd_{std::chrono::seconds{2}};
};

TEST_F(Service, IsReadyOnlyWhenEveryRequiredDeviceIsConnected) {
  auto gateway = start_gateway();
  ASSERT_TRUE(hears("STATUS=waiting for mru1")) << gateway->output();
  EXPECT_TRUE(hears("EXTEND_TIMEOUT_USEC="));  // else systemd would give up on it
  EXPECT_TRUE(hears_no("READY=1"));

  auto simulator = start_simulator();
  ASSERT_TRUE(hears("READY=1")) << gateway->output() << simulator->output();
  EXPECT_TRUE(hears("STATUS=ready: everything is fresh and healthy")) << systemd_.all();

  // A device that is lost later is said, and does not end the service.
  simulator.reset();
  EXPECT_TRUE(hears("; missing: mru1 (")) << systemd_.all();
  EXPECT_TRUE(gateway->running());
  gateway->send(SIGTERM);
  EXPECT_TRUE(hears("STOPPING=1"));
  EXPECT_EQ(gateway->exit_code(kPatience), 0);
}

TEST_F(Service, DoesNotWaitForDevicesThatAreDeclaredAbsent) {
  write("gateway.toml",
        gateway_overlay() + "[service]\nabsent = [\"mru1\", \"qualisys\", \"arm\", \"winch\"]\n");
  auto gateway = start_gateway();
  EXPECT_TRUE(hears("READY=1")) << gateway->output();
  EXPECT_TRUE(hears("declared absent: mru1 qualisys arm winch")) << systemd_.all();
}

TEST_F(Service, DoesNotStrokeTheWatchdogWhileAThreadHangs) {
  auto gateway = start_gateway();
  ASSERT_TRUE(hears("WATCHDOG=1")) << gateway->output();
  {
    const StoppedThread bus(gateway->pid(), "bus");
    ASSERT_TRUE(eventually(
        [&] { return gateway->output().find("no answer from thread bus") != std::string::npos; }, kPatience));
    systemd_.forget();
    EXPECT_TRUE(hears_no("WATCHDOG=1"));
    EXPECT_TRUE(hears("STATUS="));  // the house is well; that is not enough
  }
  EXPECT_TRUE(hears("WATCHDOG=1"));  // a thread that goes on in time is forgiven
}

TEST_F(Service, TakesWhatMayChangeLiveAndRefusesTheRestByName) {
  auto simulator = start_simulator();
  auto gateway = start_gateway();
  ASSERT_TRUE(hears("READY=1")) << gateway->output();

  write("gateway.toml", gateway_overlay() +
                            "[service]\nabsent = [\"mru2\"]\n[control]\nperiod_s = 0.002\n"
                            "[reference]\np_world_load_m = [0.84, -0.40, 3.91]\n");
  systemd_.forget();
  gateway->send(SIGHUP);
  EXPECT_TRUE(hears("RELOADING=1\nMONOTONIC_USEC="));
  EXPECT_TRUE(hears("READY=1"));
  EXPECT_TRUE(hears("reload refused [control] period_s")) << systemd_.all();
  EXPECT_THAT(gateway->output(), HasSubstr("[service] absent is taken"));
  EXPECT_THAT(gateway->output(), HasSubstr("[reference] p_world_load_m is taken"));
  EXPECT_THAT(gateway->output(), HasSubstr("[control] period_s stays as it was: it is read at start only"));

  // A file with an error changes nothing and ends nothing.
  write("gateway.toml", gateway_overlay() + "[service]\nabsent = [\"crane\"]\n");
  systemd_.forget();
  gateway->send(SIGHUP);
  EXPECT_TRUE(hears("READY=1"));
  EXPECT_TRUE(hears("reload refused: the configuration has an error")) << systemd_.all();
  EXPECT_THAT(gateway->output(), HasSubstr("there is no device crane"));
  EXPECT_TRUE(gateway->running());
}

}  // namespace
}  // namespace motionlab::integration
