#include "gateway/console/http.hpp"

#include <gtest/gtest.h>

namespace motionlab::console {
namespace {

const Neighbours kNeighbours{{"lab-pc"}, {"https://app.example.org"}};

TEST(Neighbours, KnowTheNamesThatAreOurs) {
  for (const char* ours : {"localhost", "localhost:8080", "127.0.0.1:8080", "192.168.90.70", "[::1]:8080",
                           "lab-pc:1", "lab-pc"}) {
    EXPECT_TRUE(kNeighbours.host_is_ours(ours)) << ours;
  }
  for (const char* bent : {"", "evil.example", "localhost.evil.example:8080", "127.0.0.1.evil.example",
                           "lab-pc.evil.example", "[", "1"}) {
    EXPECT_FALSE(kNeighbours.host_is_ours(bent)) << bent;
  }
}

TEST(Neighbours, LetOwnPagesLocalOnesAndAllowedOnesIn) {
  for (const char* known : {"", "file://", "http://192.168.90.70:8080", "http://localhost:3000",
                            "http://127.0.0.1:5000", "http://[::1]:5000", "https://app.example.org"}) {
    EXPECT_TRUE(kNeighbours.origin_may(known, "192.168.90.70:8080")) << known;
  }
  for (const char* stranger :
       {"null", "http://evil.example", "http://192.168.90.70:9090", "https://app.example.org.evil.example",
        "http://localhost.evil.example", "x"}) {
    EXPECT_FALSE(kNeighbours.origin_may(stranger, "192.168.90.70:8080")) << stranger;
  }
}

}  // namespace
}  // namespace motionlab::console
