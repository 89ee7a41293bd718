// Who may see the live view.
#include <gtest/gtest.h>
#include <unistd.h>

#include "view/view_access.h"

namespace scanknit {
namespace {

TEST(ViewAccess, TokensAre128RandomBits) {
  const std::string token = random_token();
  EXPECT_EQ(token.size(), 32u);
  EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_NE(token, random_token());
}

TEST(ViewAccess, SecretsAreComparedWhole) {
  EXPECT_TRUE(is_same_secret("abc", "abc"));
  EXPECT_FALSE(is_same_secret("abd", "abc"));
  EXPECT_FALSE(is_same_secret("ab", "abc"));
  EXPECT_FALSE(is_same_secret("abcd", "abc"));
  EXPECT_FALSE(is_same_secret("", "abc"));
}

TEST(ViewAccess, AddressesAndOwnNamesAreOwnHosts) {
  std::string name(256, '\0');
  ASSERT_EQ(gethostname(name.data(), name.size() - 1), 0);
  name.resize(name.find('\0'));
  for (const std::string& host :
       {std::string("127.0.0.1"), std::string("127.0.0.1:8765"), std::string("[::1]:80"), std::string("192.168.0.7:1"),
        std::string("localhost:9000"), std::string("LocalHost"), name, name + ".local:8765"}) {
    EXPECT_TRUE(is_own_host(host)) << host;
  }
}

TEST(ViewAccess, NamesOfOthersAreNot) {
  for (const char* host :
       {"", "evil.example", "evil.example:8765", "localhost.evil.example", "127.0.0.1.evil.example", "[::1",
        "[evil]:80", ":8765", "1.2.3", "127.0.0.1:1; script-src *", "[::1]evil.example", "localhost:80@evil.example"}) {
    EXPECT_FALSE(is_own_host(host)) << host;
  }
}

TEST(ViewAccess, OnlyThePageOfThisHostIsAnOwnOrigin) {
  EXPECT_TRUE(is_own_origin("http://127.0.0.1:8765", "127.0.0.1:8765"));
  for (const char* origin : {"", "null", "http://127.0.0.1:8766", "https://127.0.0.1:8765", "http://evil.example",
                             "http://127.0.0.1:8765.evil.example"}) {
    EXPECT_FALSE(is_own_origin(origin, "127.0.0.1:8765")) << origin;
  }
}

TEST(ViewAccess, ValuesAreFoundByTheirWholeName) {
  EXPECT_EQ(value_of("a=1&token=xyz&b=2", "token", "&"), "xyz");
  EXPECT_EQ(value_of("atoken=1", "token", "&"), "");
  EXPECT_EQ(value_of("a=1; token=xyz", "token", "; "), "xyz");
  EXPECT_EQ(value_of("token", "token", "&"), "");
  EXPECT_EQ(value_of("", "token", "&"), "");
}

TEST(ViewAccess, LinksAreAddressesOfTheWeb) {
  EXPECT_EQ(link_to("192.168.0.7", 80, ""), "http://192.168.0.7:80/");
  EXPECT_EQ(link_to("::1", 8765, "abc"), "http://[::1]:8765/?token=abc");
}

TEST(ViewAccess, NamesOfFilesComeBackFromALink) {
  const std::string name =
      "m\xc3\xb6"
      "del 1%.glb";
  EXPECT_EQ(percent_decoded(percent_encoded(name)), name);
  EXPECT_EQ(percent_encoded("a/b"), "a%2fb");
  for (const char* broken : {"%", "%2", "%zz", "a%"}) EXPECT_EQ(percent_decoded(broken), "") << broken;
}

}  // namespace
}  // namespace scanknit
