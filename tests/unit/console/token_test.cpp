#include "gateway/console/token.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "drivers/core/error.hpp"

namespace motionlab::console {
namespace {

namespace fs = std::filesystem;

class TokenFile : public testing::Test {
 protected:
  fs::path write(const std::string& text, mode_t mode = 0600) {
    std::ofstream{file_} << text;
    chmod(file_.c_str(), mode);
    return file_;
  }
  void TearDown() override { fs::remove(file_); }

  const fs::path file_ = fs::path{testing::TempDir()} / ("token-" + std::to_string(getpid()));
};

std::string refusal(const fs::path& file) {
  try {
    return "read: " + read_token(file);
  } catch (const StartupError& error) {
    return error.what();
  }
}

TEST_F(TokenFile, IsReadToTheEndOfItsFirstLine) {
  EXPECT_EQ(read_token(write("0123456789abcdef\nmore\n")), "0123456789abcdef");
  EXPECT_EQ(read_token(write("0123456789abcdef")), "0123456789abcdef");
  EXPECT_EQ(read_token(write("0123456789abcdef\r\n", 0400)), "0123456789abcdef");
}

TEST_F(TokenFile, IsRefusedWhenOthersCanReadIt) {
  for (const mode_t mode : {0640, 0604, 0660, 0644}) {
    EXPECT_NE(refusal(write("0123456789abcdef\n", mode)).find("chmod 600"), std::string::npos);
  }
}

TEST_F(TokenFile, IsRefusedWhenItIsShortLongOrNotThere) {
  EXPECT_NE(refusal(write("0123456789abcde\n")).find("15 characters"), std::string::npos);
  EXPECT_NE(refusal(write("\n")).find("0 characters"), std::string::npos);
  EXPECT_NE(refusal(write(std::string(300, 'x'))).find("16 to 256"), std::string::npos);
  EXPECT_NE(refusal("/nowhere/token").find("/nowhere/token"), std::string::npos);
  EXPECT_NE(refusal(testing::TempDir()).find("no file"), std::string::npos);
}

TEST(Token, IsAnotherOneEachTime) {
  const std::string token = make_token();
  EXPECT_EQ(token.size(), 32U);
  EXPECT_NE(token, make_token());
}

TEST(Token, IsTheSameOrNot) {
  EXPECT_TRUE(same_token("abc", "abc"));
  for (const char* wrong : {"", "ab", "abcd", "abd", "bbc", "abcabc"})
    EXPECT_FALSE(same_token(wrong, "abc")) << wrong;
  EXPECT_FALSE(same_token("", ""));
  EXPECT_FALSE(same_token("x", ""));
}

}  // namespace
}  // namespace motionlab::console
