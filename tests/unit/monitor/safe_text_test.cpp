#include "gateway/monitor/safe_text.hpp"

#include <gtest/gtest.h>

namespace motionlab::monitor {
namespace {

TEST(SafeText, LeavesWordsAndLettersOfAllLanguagesAlone) {
  EXPECT_EQ(escaped("mru1 is silent: 3 °, Ålesund, 船"), "mru1 is silent: 3 °, Ålesund, 船");
  EXPECT_EQ(escaped(""), "");
}

TEST(SafeText, LeavesNoControlCharacter) {
  EXPECT_EQ(escaped("\033[2Jevil\r\n\ttext\x7f"), "\\x1b[2Jevil\\x0d\\n\\ttext\\x7f");
  EXPECT_EQ(escaped(std::string_view{"a\0b", 3}), "a\\x00b");
  for (int byte = 0; byte < 256; ++byte) {
    const std::string text = escaped(std::string(1, static_cast<char>(byte)));
    for (const char character : text) EXPECT_TRUE(character >= 0x20 && character < 0x7F) << byte;
  }
}

TEST(SafeText, EscapesControlsThatHideInUtf8) {
  EXPECT_EQ(escaped("\u009b2J"), "\\u{9b}2J");                // the one-character CSI
  EXPECT_EQ(escaped("a\u202egnp.exe"), "a\\u{202e}gnp.exe");  // turns the direction of writing
}

TEST(SafeText, EscapesBytesThatAreNoUtf8) {
  EXPECT_EQ(escaped("\xff\xc3"), "\\xff\\xc3");                    // never a start; cut off
  EXPECT_EQ(escaped("\xc0\x9b"), "\\xc0\\x9b");                    // overlong
  EXPECT_EQ(escaped("\xed\xa0\x80"), "\\xed\\xa0\\x80");           // a surrogate
  EXPECT_EQ(escaped("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");  // beyond the last character
}

TEST(SafeText, CanBeReadBack) {
  EXPECT_EQ(escaped("\\n"), "\\\\n");  // not to be taken for an escaped line end
}

}  // namespace
}  // namespace motionlab::monitor
