#include "drivers/core/toml_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>

#include "drivers/core/error.hpp"
#include "drivers/core/toml_hint.hpp"

namespace motionlab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// Files in a folder of their own; error texts name them without the folder.
class Toml : public testing::Test {
 protected:
  Toml() { std::filesystem::create_directories(folder_); }
  ~Toml() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  TomlDocument load(const std::string& text) { return TomlDocument::load(write("lab.toml", text)); }

  std::string error_of(const std::function<void()>& action) {
    try {
      action();
    } catch (const StartupError& error) {
      std::string text = error.what();
      const std::string prefix = folder_.string() + '/';
      for (auto at = text.find(prefix); at != std::string::npos; at = text.find(prefix))
        text.erase(at, prefix.size());
      return text;
    }
    return "no error";
  }
  std::string error_of_text(const std::string& text, const std::function<void(const TomlTable&)>& read) {
    return error_of([&] { read(load(text).root()); });
  }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("toml_reader_test_" + std::to_string(getpid()));
};

TEST_F(Toml, ReadsEveryKindOfValue) {
  const auto root = load(R"(
period_s = 0.005
whole = 3
on = true
name = "arm"
list = ["a", "b"]
home_rad = [0, 1.5, -2]
peer = "192.168.90.13:50013"
watchdog = "relay"
)")
                        .root();
  EXPECT_EQ(root.number("period_s", Range::positive()), 0.005);
  EXPECT_EQ(root.number("whole"), 3.0);
  EXPECT_EQ(root.integer("whole", {0, 5}), 3);
  EXPECT_TRUE(root.boolean("on"));
  EXPECT_EQ(root.text("name"), "arm");
  EXPECT_THAT(root.texts("list"), ElementsAre("a", "b"));
  EXPECT_THAT(root.numbers<3>("home_rad"), ElementsAre(0.0, 1.5, -2.0));
  EXPECT_THAT(root.numbers("home_rad"), ElementsAre(0.0, 1.5, -2.0));
  EXPECT_EQ(root.endpoint("peer"), (Endpoint{0xc0a85a0d, 50013}));
  EXPECT_EQ(root.choice("watchdog", {"none", "relay", "patched"}), 1u);
}

TEST_F(Toml, FallsBackWhenAKeyIsAbsentAndIsStrictWhenItIsThere) {
  const auto root = load("bad = \"x\"\n").root();
  EXPECT_EQ(root.number_or("a", 1.5), 1.5);
  EXPECT_EQ(root.integer_or("a", 7), 7);
  EXPECT_TRUE(root.boolean_or("a", true));
  EXPECT_EQ(root.text_or("a", "x"), "x");
  EXPECT_EQ(root.choice_or("a", 2, {"p", "q", "r"}), 2u);
  EXPECT_EQ(root.endpoint_or("a", {1, 2}), (Endpoint{1, 2}));
  EXPECT_THAT(root.texts_or("a", {"x"}), ElementsAre("x"));
  EXPECT_THAT(root.numbers_or<2>("a", {1.0, 2.0}), ElementsAre(1.0, 2.0));
  EXPECT_EQ(root.table_or_empty("section").number_or("a", 4.0), 4.0);
  EXPECT_THROW((void)root.number_or("bad", 1.0), StartupError);
  EXPECT_THROW((void)root.table_or_empty("bad"), StartupError);
}

TEST_F(Toml, SaysWhereAWrongTypeStandsAndWhatToWrite) {
  EXPECT_EQ(error_of_text("[comau]\nperiod_s = \"5\"\n",
                          [](const TomlTable& root) { (void)root.table("comau").number("period_s"); }),
            "lab.toml:2:12: [comau] period_s: a text stands where a number belongs; write 5 without quotes");
  EXPECT_EQ(error_of_text("name = 5\n", [](const TomlTable& root) { (void)root.text("name"); }),
            "lab.toml:1:8: name: a whole number stands where a text belongs; write it in \"quotes\"");
  EXPECT_EQ(error_of_text("on = 1\n", [](const TomlTable& root) { (void)root.boolean("on"); }),
            "lab.toml:1:6: on: a whole number stands where true or false belongs; write true or false");
  EXPECT_EQ(error_of_text("n = 1.5\n",
                          [](const TomlTable& root) {
                            (void)root.integer("n", {0, 9});
                          }),
            "lab.toml:1:5: n: a number stands where a whole number from 0 to 9 belongs; write a whole number "
            "from 0 to 9");
  EXPECT_THAT(error_of_text("t = 1\n", [](const TomlTable& root) { (void)root.table("t"); }),
              HasSubstr("lab.toml:1:5: t: a whole number stands where the table [t] belongs"));
}

TEST_F(Toml, SaysTheRangeOfANumber) {
  const auto read = [](Range range) {
    return [range](const TomlTable& root) { (void)root.number("x", range); };
  };
  EXPECT_EQ(error_of_text("x = 7.5\n", read({0, 5})),
            "lab.toml:1:5: x: 7.5 is out of range; write a number from 0 to 5");
  EXPECT_EQ(error_of_text("x = 0\n", read(Range::positive())),
            "lab.toml:1:5: x: 0 is out of range; write a number above 0");
  EXPECT_EQ(error_of_text("x = -1\n", read(Range::at_least(0))),
            "lab.toml:1:5: x: -1 is out of range; write a number of at least 0");
  EXPECT_EQ(error_of_text("x = nan\n", read({})), "lab.toml:1:5: x: is not finite; write a number");
  EXPECT_EQ(error_of_text("x = 70000\n",
                          [](const TomlTable& root) {
                            (void)root.integer("x", {1, 65535});
                          }),
            "lab.toml:1:5: x: 70000 is out of range; write a whole number from 1 to 65535");
}

TEST_F(Toml, SaysWhatListsAndWordsAndEndpointsShouldBe) {
  EXPECT_EQ(error_of_text("q = [1, 2]\n", [](const TomlTable& root) { (void)root.numbers<3>("q"); }),
            "lab.toml:1:5: q: has 2 elements; write a list of 3 numbers");
  EXPECT_EQ(error_of_text("q = [1,\n 9]\n",
                          [](const TomlTable& root) {
                            (void)root.numbers<2>("q", {0, 5});
                          }),
            "lab.toml:2:2: q: 9 is out of range; write a number from 0 to 5");
  EXPECT_EQ(error_of_text("w = \"rely\"\n",
                          [](const TomlTable& root) {
                            (void)root.choice("w", {"relay", "patched"});
                          }),
            "lab.toml:1:5: w: \"rely\" is not known; write \"relay\" or \"patched\"");
  EXPECT_EQ(error_of_text("e = \"host:1\"\n", [](const TomlTable& root) { (void)root.endpoint("e"); }),
            "lab.toml:1:5: e: \"host:1\" is not an endpoint; write it like 192.168.90.13:50013");
}

TEST_F(Toml, SaysWhichKeyIsMissingAndInWhichTable) {
  EXPECT_EQ(
      error_of_text("[comau]\n", [](const TomlTable& root) { (void)root.table("comau").number("period_s"); }),
      "lab.toml:1:1: [comau] period_s: is missing; write period_s = a number");
  EXPECT_EQ(error_of_text("\n", [](const TomlTable& root) { (void)root.table("comau"); }),
            "lab.toml:1:1: the table [comau] is missing; write it");
}

TEST_F(Toml, AKeyInAnotherUnitIsNamedWithTheRightOne) {
  const std::string expected =
      "lab.toml:2:1: [comau] period_ms: unknown key period_ms; did you mean period_s (seconds)?";
  EXPECT_EQ(error_of_text("[comau]\nperiod_ms = 5\n",
                          [](const TomlTable& root) { (void)root.table("comau").number("period_s"); }),
            expected);
  EXPECT_EQ(error_of([&] {
              const auto document = load("[comau]\nperiod_ms = 5\n");
              (void)document.root().table("comau").number_or("period_s", 0.005);
              document.refuse_unknown_keys();
            }),
            expected);
}

TEST_F(Toml, RefusesTheFirstKeyThatNobodyAskedFor) {
  const auto error_after = [&](const std::string& text) {
    return error_of([&] {
      const auto document = load(text);
      const auto table = document.root().table_or_empty("mru");
      (void)table.number_or("rate_hz", 200.0);
      (void)table.text_or("units", "");
      document.refuse_unknown_keys();
    });
  };
  EXPECT_EQ(error_after("[mru]\nrate_hz = 100\n"), "no error");
  EXPECT_EQ(error_after("[mru]\nzebra = 1\nratr_hz = 100\nalpha = 1\n"),
            "lab.toml:2:1: [mru] zebra: unknown key zebra; remove it, or write one of: rate_hz units");
  EXPECT_EQ(error_after("[mru]\nratr_hz = 100\n"),
            "lab.toml:2:1: [mru] ratr_hz: unknown key ratr_hz; did you mean rate_hz (hertz)?");
  EXPECT_THAT(error_after("[mrru]\nrate_hz = 100\n"), HasSubstr("unknown table mrru; did you mean mru?"));
  EXPECT_THAT(error_after("[mru.inner]\nx = 1\n"), HasSubstr("[mru] inner: unknown table inner"));
}

TEST_F(Toml, ATableThatWasOnlyLookedForStillHasUnknownKeys) {
  const auto document = load("[mru]\nx = 1\n");
  EXPECT_TRUE(document.root().has("mru"));
  EXPECT_EQ(error_of([&] { document.refuse_unknown_keys(); }),
            "lab.toml:2:1: [mru] x: unknown key x; remove it, nothing is known here");
}

TEST_F(Toml, ListsTheTablesThatTheUserNamed) {
  const auto document = load("[mru]\ncommon = 1\n[mru.b]\nx = 2\n[mru.a]\nx = 1\n");
  const auto tables = document.root().table("mru").tables();
  ASSERT_EQ(tables.size(), 2u);
  EXPECT_EQ(tables[0].name(), "a");
  EXPECT_EQ(tables[1].path(), "mru.b");
  EXPECT_EQ(tables[1].integer("x"), 2);
}

TEST_F(Toml, AnOverlayReplacesSingleValuesHoweverDeep) {
  const auto base =
      write("lab.toml", "[comau]\nperiod_s = 0.005\npeer = \"10.0.0.1:1\"\n[comau.limit]\na = 1\nb = 2\n");
  const auto over =
      write("loopback.toml", "[comau]\npeer = \"127.0.0.1:1\"\n[comau.limit]\nb = 20\nc = \"new\"\n");
  const auto last = write("last.toml", "[comau.limit]\nb = 200\n");
  const auto document = TomlDocument::load(base, {over, last});
  const auto comau = document.root().table("comau");
  EXPECT_EQ(comau.number("period_s"), 0.005);
  EXPECT_EQ(comau.text("peer"), "127.0.0.1:1");
  EXPECT_EQ(comau.table("limit").integer("a"), 1);
  EXPECT_EQ(comau.table("limit").integer("b"), 200);
  EXPECT_EQ(error_of([&] { (void)comau.table("limit").number("c"); }),
            "loopback.toml:5:5: [comau.limit] c: a text stands where a number belongs; write a number");
  EXPECT_EQ(error_of([&] { document.refuse_unknown_keys(); }), "no error");
}

TEST_F(Toml, AnUnknownKeyOfAnOverlayIsFoundInTheOverlay) {
  const auto base = write("lab.toml", "[comau]\nperiod_s = 0.005\n");
  const auto over = write("loopback.toml", "\n[comau]\nperid_s = 0.01\n[extra]\n");
  const auto document = TomlDocument::load(base, {over});
  (void)document.root().table("comau").number("period_s");
  EXPECT_EQ(error_of([&] { document.refuse_unknown_keys(); }),
            "loopback.toml:3:1: [comau] perid_s: unknown key perid_s; did you mean period_s (seconds)?");
}

TEST_F(Toml, ShowsTheEffectiveConfigurationAsToml) {
  const auto base = write("lab.toml", "[b]\ny = 2\n[a]\nx = 1.5\n");
  const auto over = write("over.toml", "[b]\ny = 3\n");
  const std::string effective = TomlDocument::load(base, {over}).effective();
  const auto again = TomlDocument::load(write("again.toml", effective));
  EXPECT_EQ(again.root().table("b").integer("y"), 3);
  EXPECT_EQ(again.root().table("a").number("x"), 1.5);
  EXPECT_EQ(again.effective(), effective);
}

TEST_F(Toml, WhatIsPrintedKeepsEveryText) {
  const std::string printed = load("a = \"\\nsecond line\\n\"\nb = 'raw \\ text'\n").effective();
  const auto again = TomlDocument::load(write("again.toml", printed));
  EXPECT_EQ(again.root().text("a"), "\nsecond line\n");
  EXPECT_EQ(again.root().text("b"), "raw \\ text");
}

TEST_F(Toml, AMissingFileIsNamed) {
  EXPECT_THAT(error_of([&] { (void)TomlDocument::load(folder_ / "nowhere.toml"); }),
              HasSubstr("nowhere.toml: there is no such file; check the path"));
  const auto base = write("lab.toml", "");
  EXPECT_THAT(error_of([&] { (void)TomlDocument::load(base, {folder_ / "over.toml"}); }),
              HasSubstr("over.toml: there is"));
}

TEST_F(Toml, SyntaxErrorsAndDuplicatesHaveAPosition) {
  EXPECT_THAT(error_of([&] { (void)load("a = 1\nb = \n"); }), HasSubstr("lab.toml:2:"));
  EXPECT_THAT(error_of([&] { (void)load("a = 1\na = 2\n"); }),
              testing::AllOf(HasSubstr("lab.toml:2:"), HasSubstr("'a'")));
}

TEST_F(Toml, AKeyThatNeedsQuotesIsRefusedWhereItStands) {
  const auto nothing = [](const TomlTable&) {};
  EXPECT_THAT(error_of_text("[a]\nx = 1\n\"'y\" = 2\n", nothing),
              testing::StartsWith("lab.toml:3:1: a key has"));
  EXPECT_THAT(error_of_text("x = [{ \"\" = 1 }]\n", nothing), HasSubstr("a key has other characters"));
}

TEST_F(Toml, TheCallerCanRefuseAValueAtItsPosition) {
  EXPECT_EQ(
      error_of_text("[a]\nx = 1\ny = 2\n",
                    [](const TomlTable& root) { root.table("a").fail("y", "is less than x; swap them"); }),
      "lab.toml:3:5: [a] y: is less than x; swap them");
}

TEST_F(Toml, AHandleKeepsTheDocumentAlive) {
  const auto table = [&] { return load("[a.b]\nx = 1\n").root().table("a").table("b"); }();
  EXPECT_EQ(table.integer("x"), 1);
}

TEST(TomlHint, KnowsUnitsAndClosestKeys) {
  EXPECT_EQ(unit_of_key("period_s"), "seconds");
  EXPECT_EQ(unit_of_key("limit_radps2"), "radians per second squared");
  EXPECT_EQ(unit_of_key("period"), "");
  EXPECT_TRUE(differ_in_unit_only("period_s", "period_ms"));
  EXPECT_TRUE(differ_in_unit_only("period", "period_s"));
  EXPECT_FALSE(differ_in_unit_only("noise_m", "noise_rad"));
  EXPECT_FALSE(differ_in_unit_only("period_s", "period_s"));
  EXPECT_EQ(closest_key("angle_deg", {"angel_m", "angle_rad"}), "angle_rad");
  EXPECT_EQ(closest_key("sped", {"gain", "speed"}), "speed");
  EXPECT_EQ(closest_key("quite_different", {"gain", "speed"}), std::nullopt);
}

}  // namespace
}  // namespace motionlab
