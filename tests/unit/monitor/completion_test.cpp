#include "gateway/monitor/completion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <sstream>

namespace motionlab::monitor {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// A program like ours in small.
class Completion : public testing::Test {
 protected:
  Completion() {
    app_.add_option("--domain", number_, "DDS domain");
    app_.add_flag("--json", flag_, "in [JSON]: it's \"machine\" readable");
    CLI::App* const echo = app_.add_subcommand("echo", "samples");
    echo->add_option("topic", text_, "which")->type_name("TOPIC");
    echo->add_flag("--once", flag_, "one");
    CLI::App* const authority = app_.add_subcommand("authority", "how much");
    authority->add_option("level", text_, "which")
        ->type_name("LEVEL")
        ->check(CLI::IsMember({"full", "observe"}));
    authority->add_option("--frame", text_, "which")->check(CLI::IsMember({"world", "em1500"}));
    app_.add_subcommand("check", "listens")
        ->add_subcommand("mru", "a unit")
        ->add_option("--listen", number_, "port");
  }

  /// What bash offers after this line; the last word is the one being written.
  std::set<std::string> offered(const std::string& line) {
    const auto folder = std::filesystem::path(testing::TempDir());
    const auto script = folder / ("completion-" + std::to_string(getpid()) + ".bash");
    std::ofstream(script) << bash_completion(app_, {{"TOPIC", {"motionlab/mru", "motionlab/mode"}}})
                          << "\nread -r -a COMP_WORDS <<< '" << line
                          << "x'\nCOMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n"
                          << "COMP_WORDS[COMP_CWORD]=${COMP_WORDS[COMP_CWORD]%x}\n_hand\n"
                          << "printf '%s\\n' \"${COMPREPLY[@]}\"\n";
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe{
        popen(("bash -u " + script.string() + " 2>&1").c_str(), "r"), pclose};
    std::string output;
    std::array<char, 4096> part{};
    while (std::fgets(part.data(), part.size(), pipe.get())) output += part.data();
    std::filesystem::remove(script);
    std::istringstream lines{output};
    std::set<std::string> words;
    for (std::string word; std::getline(lines, word);) {
      if (!word.empty()) words.insert(word);
    }
    return words;
  }

  CLI::App app_{"A hand.", "hand"};
  int number_ = 0;
  bool flag_ = false;
  std::string text_;
};

TEST_F(Completion, OffersCommandsAndOptionsOfTheProgram) {
  EXPECT_THAT(offered("hand "),
              testing::IsSupersetOf({"echo", "authority", "check", "--domain", "--json", "--help"}));
  EXPECT_EQ(offered("hand ec"), std::set<std::string>{"echo"});
  EXPECT_EQ(offered("hand --js"), std::set<std::string>{"--json"});
}

TEST_F(Completion, OffersWhatBelongsToTheCommandAndWhatIsCommon) {
  const auto words = offered("hand --json echo ");
  EXPECT_THAT(words, testing::IsSupersetOf({"motionlab/mru", "motionlab/mode", "--once", "--domain"}));
  EXPECT_THAT(words, Not(Contains("authority")));
  EXPECT_EQ(offered("hand echo motionlab/mr"), std::set<std::string>{"motionlab/mru"});
}

TEST_F(Completion, OffersTheChoicesOfAnOption) {
  EXPECT_THAT(offered("hand authority "), testing::IsSupersetOf({"full", "observe", "--frame"}));
  EXPECT_EQ(offered("hand authority --frame "), (std::set<std::string>{"world", "em1500"}));
  EXPECT_THAT(offered("hand --domain "), IsEmpty());  // a number: nothing to offer
}

TEST_F(Completion, FindsCommandsOfCommands) {
  EXPECT_THAT(offered("hand check "), Contains("mru"));
  EXPECT_THAT(offered("hand check mru --li"), Contains("--listen"));
}

TEST_F(Completion, ForZshQuotesWhatZshWouldRead) {
  const std::string script = zsh_completion(app_, {{"TOPIC", {"motionlab/mru"}}});
  EXPECT_THAT(script, testing::StartsWith("#compdef hand\n"));
  EXPECT_THAT(script, HasSubstr("'[in \\[JSON\\]\\: it'\\''s \"machine\" readable]'"));
  EXPECT_THAT(script, HasSubstr(":TOPIC:(motionlab/mru)'"));
  EXPECT_THAT(script, HasSubstr("_hand_check_mru()"));
  EXPECT_THAT(script, HasSubstr("'echo:samples'"));
}

}  // namespace
}  // namespace motionlab::monitor
