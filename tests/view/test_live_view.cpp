// The server, asked by well-meaning, slow and hostile clients.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <future>
#include <random>
#include <set>
#include <thread>

#include "tests/view/page_client.h"
#include "view/live_view.h"
#include "view/mesh_chunk.h"
#include "view/page_files.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::http_request;
using test::PageClient;

std::uint16_t port_of(const std::string& link) {
  return static_cast<std::uint16_t>(std::stoi(link.substr(link.rfind(':') + 1)));
}

/// A server on any free port.
class LiveViewTest : public testing::Test {
 protected:
  void SetUp() override {
    if (page_files().empty()) GTEST_SKIP() << "SKIPPED: built without the page (npm ci --prefix view/page)";
  }

  void start(const std::string& token = "") {
    LiveViewOptions options;
    options.port = 0;
    options.token = token;
    ViewHello hello;
    hello.title = "test";
    auto started = LiveView::start(options, hello);
    ASSERT_TRUE(started) << started.error().text();
    view = *std::move(started);
    port = port_of(view->links().front());
    view->publish(ViewState{});
  }

  /// The number of chunks is the revision that their messages name.
  void publish_chunk(std::uint32_t chunk, std::uint32_t revision) {
    view->publish_chunk(chunk, chunk_gone_message(chunk, revision));
  }

  void expect_that_it_still_serves() {
    EXPECT_EQ(http_request(port, "GET", "/api/v1/state").status, 200);
    const auto client = PageClient::connect(port);
    ASSERT_NE(client, nullptr);
    EXPECT_EQ(client->next_of("hello")["title"], "test");
  }

  std::unique_ptr<LiveView> view;
  std::uint16_t port = 0;
};

std::uint32_t number_at(const std::string& message, std::size_t offset) {
  std::uint32_t value = 0;
  std::memcpy(&value, message.data() + offset, sizeof(value));
  return value;
}

TEST_F(LiveViewTest, ServesThePageUnderAStrictPolicy) {
  start();
  const auto page = http_request(port, "GET", "/");
  EXPECT_EQ(page.status, 200);
  const std::string policy = page.fields.at("content-security-policy");
  EXPECT_NE(policy.find("default-src 'none'"), std::string::npos);
  EXPECT_EQ(policy.find("unsafe"), std::string::npos);
  EXPECT_EQ(page.fields.at("x-content-type-options"), "nosniff");
  EXPECT_EQ(page.fields.count("access-control-allow-origin"), 0u);
  for (const char* path : {"/view.js", "/view.css", "/icon.svg"})
    EXPECT_EQ(http_request(port, "GET", path).status, 200);
}

TEST_F(LiveViewTest, RefusesWhatItDoesNotKnow) {
  start();
  for (const char* path : {"/index.html", "/view.js/", "/api/v1", "/files/", "/files/../test", "//", "/%2e%2e/"})
    EXPECT_EQ(http_request(port, "GET", path).status, 404) << path;
  for (const char* method : {"POST", "PUT", "DELETE", "HEAD", "OPTIONS", "TRACE"})
    EXPECT_EQ(http_request(port, method, "/").status, 405) << method;
  EXPECT_EQ(http_request(port, "GET", "/", {}, "a body").status, 413);
  EXPECT_EQ(http_request(port, "POST", "/", {}, "a body").status, 405);
  EXPECT_EQ(http_request(port, "GET", "/", {{"X-Long", std::string(20'000, 'x')}}).status, 413);
  EXPECT_EQ(http_request(port, "GET", "/api/v1/live").status, 426);
}

TEST_F(LiveViewTest, RefusesNamesThatOthersPointHere) {
  start();
  EXPECT_EQ(http_request(port, "GET", "/", {{"Host", "evil.example"}}).status, 403);
  EXPECT_EQ(http_request(port, "GET", "/", {{"Host", "localhost:9000"}}).status, 200);
}

TEST_F(LiveViewTest, RefusesARequestOfTwoHosts) {
  start();
  const std::string own = "Host: 127.0.0.1:" + std::to_string(port) + "\r\n";
  const auto status_of = [&](const std::string& hosts) {
    return test::answer_to(port, "GET /api/v1/state HTTP/1.1\r\nConnection: close\r\n" + hosts + "\r\n").substr(9, 3);
  };
  EXPECT_EQ(status_of(own), "200");
  EXPECT_EQ(status_of(own + "Host: evil.example\r\n"), "400");
  EXPECT_EQ(status_of("Host: evil.example\r\n" + own), "400");
  EXPECT_EQ(status_of(""), "400");
}

TEST_F(LiveViewTest, SilentConnectionsDoNotBlockOtherClients) {
  start();
  const auto looks_on = PageClient::connect(port);
  ASSERT_NE(looks_on, nullptr);
  EXPECT_EQ(looks_on->next_of("hello")["title"], "test");
  std::vector<std::unique_ptr<test::SilentConnection>> strangers;
  for (int i = 0; i < 200; ++i) strangers.push_back(std::make_unique<test::SilentConnection>(port));
  expect_that_it_still_serves();
  ViewState state;
  state.frame = 7;
  view->publish(state);
  for (auto told = looks_on->next_of("state"); told["frame"] != 7; told = looks_on->next_of("state")) {
    ASSERT_FALSE(told.is_null()) << "who was there has been thrown out";
  }
}

TEST_F(LiveViewTest, CommandsThatAreNotTakenAreAnsweredByTheServer) {
  start();
  const auto client = PageClient::connect(port);
  ASSERT_NE(client, nullptr);
  view->refuse_commands("not yet");
  EXPECT_EQ(client->next_of("hello")["title"], "test");
  client->say(R"({"cmd":"finish","id":1})");
  EXPECT_EQ(client->next_of("ack")["error"], "not yet");
  EXPECT_FALSE(view->next_command({}, 0ns));
  view->refuse_commands("");
  client->say(R"({"cmd":"finish","id":2})");
  EXPECT_TRUE(view->next_command({}, 3s));
}

TEST_F(LiveViewTest, RefusesTheWebSocketsOfOtherPages) {
  start();
  for (const char* origin : {"", "null", "http://evil.example", "http://127.0.0.1:1"}) {
    int status = 0;
    EXPECT_EQ(PageClient::connect(port, "/api/v1/live", origin, &status), nullptr) << origin;
    EXPECT_EQ(status, 403) << origin;
  }
}

TEST_F(LiveViewTest, RefusesAWebSocketWithTwoOrigins) {
  start();
  const std::string own = "Origin: http://127.0.0.1:" + std::to_string(port) + "\r\n";
  const std::string request = "GET /api/v1/live HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) +
                              "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                              "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Protocol: scanknit.v1\r\n";
  for (const std::string& origins : {own + own, own + "Origin: http://evil.example\r\n"}) {
    EXPECT_EQ(test::answer_to(port, request + origins + "\r\n").substr(9, 3), "403") << origins;
  }
  expect_that_it_still_serves();
}

TEST_F(LiveViewTest, RefusesWebSocketsOfAnotherProtocol) {
  start();
  for (const char* offered : {"", "scanknit.v2", "chat, superchat"}) {
    std::map<std::string, std::string> fields = {{"Upgrade", "websocket"},
                                                 {"Connection", "Upgrade"},
                                                 {"Sec-WebSocket-Key", "AAAAAAAAAAAAAAAAAAAAAA=="},
                                                 {"Sec-WebSocket-Version", "13"},
                                                 {"Origin", "http://127.0.0.1:" + std::to_string(port)}};
    if (*offered != '\0') fields["Sec-WebSocket-Protocol"] = offered;
    EXPECT_EQ(http_request(port, "GET", "/api/v1/live", fields).status, 400) << offered;
  }
  expect_that_it_still_serves();
}

TEST_F(LiveViewTest, AsksForTheTokenWhereThereIsOne) {
  const std::string token = "0123456789abcdef";
  start(token);
  EXPECT_NE(view->links().front().find("/?token=" + token), std::string::npos);
  for (const char* target : {"/", "/?token=", "/?token=0123456789abcdee", "/api/v1/state", "/files/x"})
    EXPECT_EQ(http_request(port, "GET", target).status, 401) << target;
  int status = 0;
  EXPECT_EQ(PageClient::connect(port, "/api/v1/live", std::nullopt, &status), nullptr);
  EXPECT_EQ(status, 401);
  EXPECT_NE(PageClient::connect(port, "/api/v1/live?token=" + token), nullptr);
  EXPECT_EQ(http_request(port, "GET", "/view.js").status, 200);  // no secret

  const auto page = http_request(port, "GET", "/?token=" + token);
  ASSERT_EQ(page.status, 200);
  const std::string cookie = page.fields.at("set-cookie");
  EXPECT_NE(cookie.find("HttpOnly"), std::string::npos);
  EXPECT_NE(cookie.find("SameSite=Strict"), std::string::npos);
  EXPECT_EQ(http_request(port, "GET", "/api/v1/state", {{"Cookie", cookie.substr(0, cookie.find(';'))}}).status, 200);
}

TEST_F(LiveViewTest, MakesATokenWhereOthersReachIt) {
  LiveViewOptions options;
  options.address = "0.0.0.0";
  options.port = 0;
  const auto open = LiveView::start(options, {});
  ASSERT_TRUE(open) << open.error().text();
  for (const std::string& link : (*open)->links()) EXPECT_NE(link.find("?token="), std::string::npos) << link;
}

TEST_F(LiveViewTest, BeginsWithHelloAndTheNewest) {
  start();
  ViewState state;
  state.frame = 7;
  view->publish(state);
  view->publish(ViewPose{});
  publish_chunk(1, 1);
  publish_chunk(1, 2);
  const auto client = PageClient::connect(port);
  ASSERT_NE(client, nullptr);
  EXPECT_EQ(client->next_of("hello")["title"], "test");
  EXPECT_TRUE(client->next_of("files")["files"].empty()) << "those of a program before are no more";
  EXPECT_TRUE(client->next_of("crop")["box"].is_null());
  EXPECT_EQ(client->next_of("trail")["points"].size(), 1u);
  EXPECT_EQ(client->next_of("state")["frame"], 7);
  EXPECT_EQ(client->next_of("pose")["T"].size(), 16u);
  const auto chunks = client->next_binaries(/*gives_credit=*/true);
  ASSERT_EQ(chunks.size(), 1u);
  EXPECT_EQ(number_at(chunks.front(), 12), 2u);
}

TEST_F(LiveViewTest, SendsNoMoreThanThereIsCreditFor) {
  start();
  constexpr std::uint32_t kChunks = 20, kInFlight = 8;  // docs/live_view.md
  for (std::uint32_t chunk = 0; chunk < kChunks; ++chunk) publish_chunk(chunk, 1);
  const auto client = PageClient::connect(port);
  ASSERT_NE(client, nullptr);
  ASSERT_EQ(client->next_binaries(/*gives_credit=*/false).size(), kInFlight);
  for (std::uint32_t chunk = 0; chunk < kChunks; ++chunk) publish_chunk(chunk, 2);
  client->say(R"({"got":8})");
  const auto rest = client->next_binaries(/*gives_credit=*/true);
  ASSERT_EQ(rest.size(), kChunks);
  for (const std::string& message : rest) EXPECT_EQ(number_at(message, 12), 2u) << "an old revision";
}

TEST_F(LiveViewTest, CommandsArriveAndAreAnswered) {
  start();
  const auto client = PageClient::connect(port);
  ASSERT_NE(client, nullptr);
  client->say(R"({"cmd":"export","id":42})");
  const auto command = view->next_command({}, 3s);
  ASSERT_TRUE(command);
  EXPECT_EQ(command->action, ViewAction::kExport);
  view->answer(*command, "the disk is full");
  const auto answer = client->next_of("ack");
  EXPECT_EQ(answer["id"], 42);
  EXPECT_EQ(answer["ok"], false);
  EXPECT_EQ(answer["error"], "the disk is full");
}

TEST_F(LiveViewTest, TooManyCommandsAreRefusedNotQueued) {
  start();
  const auto client = PageClient::connect(port);
  ASSERT_NE(client, nullptr);
  for (int id = 0; id < 80; ++id) client->say(R"({"cmd":"pause","id":)" + std::to_string(id) + "}");
  EXPECT_EQ(client->next_of("ack")["ok"], false);
}

TEST_F(LiveViewTest, ServesTheNamedFilesAndNoOthers) {
  start();
  const fs::path folder = fs::path(testing::TempDir()) / "live view files";
  fs::create_directories(folder);
  std::ofstream(folder / "my model.glb") << "glTF";
  std::ofstream(folder / "secret.txt") << "secret";
  view->publish_files({folder / "my model.glb", folder / "absent.stl"});
  const auto client = PageClient::connect(port);
  ASSERT_NE(client, nullptr);
  const auto files = client->next_of("files")["files"];
  ASSERT_EQ(files.size(), 1u);
  EXPECT_EQ(files[0]["name"], "my model.glb");
  EXPECT_EQ(files[0]["bytes"], 4);
  const auto file = http_request(port, "GET", "/files/my%20model.glb");
  EXPECT_EQ(file.status, 200);
  EXPECT_EQ(file.body, "glTF");
  EXPECT_NE(file.fields.at("content-disposition").find("attachment"), std::string::npos);
  for (const char* path : {"/files/secret.txt", "/files/absent.stl", "/files/..%2fsecret.txt", "/files/%00"})
    EXPECT_EQ(http_request(port, "GET", path).status, 404) << path;
  fs::remove_all(folder);
  EXPECT_EQ(http_request(port, "GET", "/files/my%20model.glb").status, 404);
}

TEST_F(LiveViewTest, NonsenseEndsOneConnectionAndNothingElse) {
  start();
  std::mt19937 random(1);
  for (int round = 0; round < 60; ++round) {
    std::string nonsense(random() % 3'000, '\0');
    for (char& c : nonsense) c = static_cast<char>(random());
    const auto client = PageClient::connect(port);
    ASSERT_NE(client, nullptr) << round;
    if (round % 3 == 0) client->say_binary(nonsense);
    if (round % 3 == 1) client->say("{\"cmd\":\"" + std::to_string(random()) + "\"}");
    if (round % 3 == 2) client->say(std::string(70'000, ' '));
    while (client->next()) {
    }
  }
  expect_that_it_still_serves();
}

TEST_F(LiveViewTest, SurvivesBytesThatAreNotHttp) {
  start();
  std::mt19937 random(2);
  for (int round = 0; round < 100; ++round) {
    std::string bytes = round % 2 == 0 ? "" : "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n";
    for (std::size_t i = random() % 300; i > 0; --i) bytes += static_cast<char>(random());
    test::send_bytes(port, bytes);
  }
  expect_that_it_still_serves();
}

TEST_F(LiveViewTest, AClientThatVanishesInMidStreamLeavesTheOthersAlone) {
  start();
  const auto stays = PageClient::connect(port);
  auto goes = PageClient::connect(port);
  ASSERT_NE(stays, nullptr);
  ASSERT_NE(goes, nullptr);
  const std::string large(1'000'000, 'x');
  for (std::uint32_t chunk = 0; chunk < 8; ++chunk) view->publish_chunk(chunk, chunk_gone_message(chunk, 1) + large);
  (void)goes->next();
  goes->vanish();
  EXPECT_EQ(stays->next_binaries(/*gives_credit=*/true).size(), 8u);
  expect_that_it_still_serves();
}

TEST_F(LiveViewTest, TwentyClientsGetEverythingAndTheThirtyThirdIsTurnedAway) {
  start();
  std::vector<std::unique_ptr<PageClient>> clients;
  for (int i = 0; i < 32; ++i) {
    clients.push_back(PageClient::connect(port));
    ASSERT_NE(clients.back(), nullptr) << i;
    EXPECT_EQ(clients.back()->next_of("hello")["type"], "hello");
  }
  int status = 0;
  EXPECT_EQ(PageClient::connect(port, "/api/v1/live", std::nullopt, &status), nullptr);
  EXPECT_EQ(status, 503);
  clients.resize(20);
  for (std::uint32_t chunk = 0; chunk < 5; ++chunk) publish_chunk(chunk, 1);
  for (const auto& client : clients) {
    std::set<std::uint32_t> seen;
    while (seen.size() < 5) {
      const auto message = client->next();
      ASSERT_TRUE(message);
      if (message->is_text) continue;
      seen.insert(number_at(message->bytes, 8));
      client->say(R"({"got":1})");
    }
  }
}

TEST_F(LiveViewTest, TakesAnotherPortWhenTheUsualOneIsTaken) {
  const auto first = LiveView::start({}, {});
  const auto second = LiveView::start({}, {});
  ASSERT_TRUE(first) << first.error().text();
  ASSERT_TRUE(second) << second.error().text();
  EXPECT_NE((*first)->links(), (*second)->links());
}

TEST_F(LiveViewTest, SaysWhichPortIsTaken) {
  start();
  LiveViewOptions options;
  options.port = port;
  const auto second = LiveView::start(options, {});
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kOutput);
  EXPECT_NE(second.error().text().find(std::to_string(port)), std::string::npos);
}

TEST_F(LiveViewTest, AnAddressOfVersionSixMayStandInBrackets) {
  LiveViewOptions options;
  options.port = 0;
  options.address = "[::1]";
  const auto started = LiveView::start(options, {});
  if (!started && started.error().code == ErrorCode::kOutput) GTEST_SKIP() << "SKIPPED: this computer has no IPv6";
  ASSERT_TRUE(started) << started.error().text();
  EXPECT_EQ((*started)->links().front().substr(0, 13), "http://[::1]:");
}

TEST_F(LiveViewTest, AnAddressThatIsNoneIsAUsageError) {
  for (const char* address : {"", "example.org", "300.1.1.1"}) {
    LiveViewOptions options;
    options.address = address;
    const auto view_there = LiveView::start(options, {});
    ASSERT_FALSE(view_there) << address;
    EXPECT_EQ(view_there.error().code, ErrorCode::kUsage);
  }
}

TEST_F(LiveViewTest, TheLastStateArrivesBeforeTheEnd) {
  start();
  const auto client = PageClient::connect(port);
  ASSERT_NE(client, nullptr);
  EXPECT_EQ(client->next_of("hello")["type"], "hello");
  ViewState last;
  last.phase = ViewPhase::kFinished;
  view->publish(last);
  view.reset();
  for (auto state = client->next_of("state"); !state.is_null(); state = client->next_of("state")) {
    if (state["phase"] == "finished") return;
  }
  ADD_FAILURE() << "the connection ended without it";
}

TEST_F(LiveViewTest, TheLastStateArrivesWhereAPageIsSlow) {
  start();
  const auto client = PageClient::connect(port);
  ASSERT_NE(client, nullptr);
  EXPECT_EQ(client->next_of("hello")["type"], "hello");
  view->publish_chunk(0, chunk_gone_message(0, 1) + std::string(12'000'000, 'x'));  // more than waits in a socket
  ViewState last;
  last.phase = ViewPhase::kFinished;
  view->publish(last);
  auto ending = std::async(std::launch::async, [this] { view.reset(); });
  std::this_thread::sleep_for(800ms);  // it draws
  for (auto state = client->next_of("state"); !state.is_null(); state = client->next_of("state")) {
    if (state["phase"] == "finished") return;
  }
  ADD_FAILURE() << "the connection ended without it";
}

TEST_F(LiveViewTest, EndsWhileAClientDoesNotRead) {
  start();
  const auto client = PageClient::connect(port);
  ASSERT_NE(client, nullptr);
  for (std::uint32_t chunk = 0; chunk < 2; ++chunk)
    view->publish_chunk(chunk, chunk_gone_message(chunk, 1) + std::string(20'000'000, 'x'));
  for (int i = 0; i < 100; ++i) view->publish(ViewState{});
  view.reset();  // a test that hangs here fails by its time limit
}

}  // namespace
}  // namespace scanknit
