// What the page and the server may say to each other.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "view/view_messages.h"

namespace scanknit {
namespace {

using Json = nlohmann::json;

ViewCommand command_of(std::string_view text) {
  const auto message = parse_client_message(text);
  return message ? std::get<ViewCommand>(*message) : ViewCommand{};
}

TEST(ViewMessages, TheStateSaysWhatTheProtocolNames) {
  ViewState state;
  state.phase = ViewPhase::kScanning;
  state.tracking = "lost";
  state.reason = "too fast";
  state.frame = 12;
  state.losses = {{"transport", 3}};
  const Json json = Json::parse(to_message(state));
  for (const char* key :
       {"type", "phase", "tracking", "reason", "advice", "frame", "frames_total", "fused", "dropped", "lost", "fps",
        "silent_s", "losses", "triangles", "is_behind", "is_crop_empty", "memory_mib", "view_share", "message"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_EQ(json["type"], "state");
  EXPECT_EQ(json["phase"], "scanning");
  EXPECT_EQ(json["tracking"], "lost");
  EXPECT_EQ(json["frame"], 12);
  EXPECT_EQ(json["losses"], Json::parse(R"({"transport":3})"));
  EXPECT_TRUE(Json::parse(to_message(ViewState{}))["losses"].is_object());
}

TEST(ViewMessages, APoseIsWrittenColumnAfterColumn) {
  ViewPose pose;
  pose.T_world_camera.translation() = Eigen::Vector3d(1, 2, 3);
  const Json elements = Json::parse(to_message(pose))["T"];
  ASSERT_EQ(elements.size(), 16u);
  EXPECT_EQ(elements[12], 1.0);
  EXPECT_EQ(elements[13], 2.0);
  EXPECT_EQ(elements[14], 3.0);
}

TEST(ViewMessages, NamesThatAreNoUtf8AreStillJson) {
  ViewHello hello;
  hello.title = "caf\xe9.mcap";
  EXPECT_TRUE(Json::parse(to_message(hello))["title"].is_string());
}

TEST(ViewMessages, EveryCommandIsUnderstood) {
  EXPECT_EQ(command_of(R"({"cmd":"start","id":1})").action, ViewAction::kStart);
  EXPECT_EQ(command_of(R"({"cmd":"pause","id":2})").action, ViewAction::kPause);
  EXPECT_EQ(command_of(R"({"cmd":"reset","id":3})").action, ViewAction::kReset);
  EXPECT_EQ(command_of(R"({"cmd":"export","id":4})").action, ViewAction::kExport);
  const ViewCommand finish = command_of(R"({"cmd":"finish","id":5})");
  EXPECT_EQ(finish.action, ViewAction::kFinish);
  EXPECT_EQ(finish.id, 5u);
}

TEST(ViewMessages, ACropHasTwoCornersOrNone) {
  const ViewCommand crop = command_of(R"({"cmd":"crop","id":1,"box":[[-1,0,0.5],[1,2,3]]})");
  ASSERT_TRUE(crop.box);
  EXPECT_EQ(crop.box->min(), Eigen::Vector3d(-1, 0, 0.5));
  EXPECT_EQ(crop.box->max(), Eigen::Vector3d(1, 2, 3));
  EXPECT_FALSE(command_of(R"({"cmd":"crop","id":1,"box":null})").box);
  EXPECT_EQ(Json::parse(to_message(crop.box))["box"], Json::parse("[[-1,0,0.5],[1,2,3]]"));
  EXPECT_TRUE(Json::parse(to_message(CropBox()))["box"].is_null());
}

TEST(ViewMessages, CreditIsANumberOfMessages) {
  const auto message = parse_client_message(R"({"got":3})");
  ASSERT_TRUE(message);
  EXPECT_EQ(std::get<ViewCredit>(*message).messages, 3u);
}

TEST(ViewMessages, AnythingElseIsRefused) {
  for (const char* text : {"",
                           "{",
                           "null",
                           "[]",
                           "7",
                           "{}",
                           R"({"cmd":7,"id":1})",
                           R"({"cmd":"start"})",
                           R"({"cmd":"start","id":-1})",
                           R"({"cmd":"start","id":1.5})",
                           R"({"cmd":"Start","id":1})",
                           R"({"cmd":"crop","id":1})",
                           R"({"cmd":"crop","id":1,"box":[]})",
                           R"({"cmd":"crop","id":1,"box":[[0,0,0],[1,1]]})",
                           R"({"cmd":"crop","id":1,"box":[[0,0,0],[1,0,1]]})",
                           R"({"cmd":"crop","id":1,"box":[[0,0,0],[1,1,1e300]]})",
                           R"({"cmd":"crop","id":1,"box":[[0,0,0],["1",1,1]]})",
                           R"({"got":-1})",
                           R"({"got":1e9})",
                           R"({"got":99999999})",
                           "{\"cmd\":\"\xff\",\"id\":1}"}) {
    EXPECT_FALSE(parse_client_message(text)) << text;
  }
}

TEST(ViewMessages, DeepNestingIsRefusedWithoutHarm) {
  EXPECT_FALSE(parse_client_message(std::string(60'000, '[')));
  EXPECT_FALSE(parse_client_message(std::string(30'000, '[') + std::string(30'000, ']')));
}

TEST(ViewMessages, EveryTruncationIsRefused) {
  const std::string whole = R"({"cmd":"crop","id":1,"box":[[-1,0,0.5],[1,2,3]]})";
  for (std::size_t length = 0; length < whole.size(); ++length)
    EXPECT_FALSE(parse_client_message(whole.substr(0, length))) << length;
}

}  // namespace
}  // namespace scanknit
