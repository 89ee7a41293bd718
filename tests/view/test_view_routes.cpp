// What is asked for, and who may have it.
#include <gtest/gtest.h>

#include "view/page_files.h"
#include "view/view_routes.h"

namespace scanknit {
namespace {

constexpr const char* kToken = "0123456789abcdef";

ViewRequest get(std::string_view target) {
  return {.is_get = true, .hosts = 1, .target = target, .host = "127.0.0.1:8765", .cookie = ""};
}

ViewRoute open_route(std::string_view target) {
  return route_of(get(target), "", "scanknit_8765");
}

ViewRoute guarded_route(const ViewRequest& request) {
  return route_of(request, kToken, "scanknit_8765");
}

TEST(ViewRoutes, EveryPlaceHasItsPath) {
  EXPECT_EQ(open_route("/api/v1/live").place, ViewPlace::kLive);
  EXPECT_EQ(open_route("/api/v1/state?x").place, ViewPlace::kState);
  const ViewRoute file = open_route("/files/my%20model.glb");
  EXPECT_EQ(file.place, ViewPlace::kFile);
  EXPECT_EQ(file.name, "my model.glb");
  for (const char* target : {"/api", "/api/v1/live/", "/files", "/..", "", "?", "/%2e%2e/"}) {
    EXPECT_EQ(open_route(target).status, 404u) << target;
  }
}

TEST(ViewRoutes, AnotherMethodIsRefusedWhateverElseIsWrong) {
  ViewRequest request = get("/");
  request.is_get = false;
  request.hosts = 2;
  EXPECT_EQ(guarded_route(request).status, 405u);
}

TEST(ViewRoutes, OneHostIsNamedAndItIsOurs) {
  for (const std::size_t hosts : {0u, 2u, 3u}) {
    ViewRequest request = get("/api/v1/state");
    request.hosts = hosts;
    EXPECT_EQ(guarded_route(request).status, 400u) << hosts;
  }
  ViewRequest request = get("/api/v1/state");
  request.host = "evil.example";
  EXPECT_EQ(guarded_route(request).status, 403u);
}

TEST(ViewRoutes, TheTokenStandsInTheTargetOrInTheCookieOfThisPort) {
  EXPECT_EQ(guarded_route(get("/api/v1/state")).status, 401u);
  EXPECT_EQ(guarded_route(get("/nowhere")).status, 401u) << "a stranger is not even told what there is";
  EXPECT_TRUE(guarded_route(get("/api/v1/state?token=0123456789abcdef")).is_trusted);
  ViewRequest request = get("/api/v1/state");
  request.cookie = "a=b; scanknit_8765=0123456789abcdef";
  EXPECT_TRUE(guarded_route(request).is_trusted);
  request.cookie = "scanknit_8766=0123456789abcdef";
  EXPECT_FALSE(guarded_route(request).is_trusted);
}

TEST(ViewRoutes, ThePagesOwnScriptIsForAllAndTellsOfNoTrust) {
  if (page_files().empty()) GTEST_SKIP() << "SKIPPED: built without the page (npm ci --prefix view/page)";
  const ViewRoute script = guarded_route(get("/view.js"));
  EXPECT_EQ(script.place, ViewPlace::kPage);
  EXPECT_FALSE(script.is_trusted);
  EXPECT_EQ(guarded_route(get("/")).status, 401u);
}

}  // namespace
}  // namespace scanknit
