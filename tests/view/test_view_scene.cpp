// The newest of everything, and nothing else.
#include <gtest/gtest.h>

#include "view/view_scene.h"

namespace scanknit {
namespace {

ViewBytes bytes(const char* text) {
  return std::make_shared<const std::string>(text);
}

/// What a client that has seen `serial` is sent, oldest news first.
std::vector<std::string> news_after(const ViewScene& scene, std::uint64_t serial) {
  std::vector<std::string> news;
  while (const auto chunk = scene.next_after(serial)) {
    news.push_back(*chunk->message);
    serial = chunk->serial;
  }
  return news;
}

TEST(ViewScene, ALateClientGetsTheNewestOfEachChunk) {
  ViewScene scene;
  scene.set_chunk(1, bytes("1 old"));
  scene.set_chunk(2, bytes("2"));
  scene.set_chunk(1, bytes("1 new"));
  EXPECT_EQ(news_after(scene, 0), (std::vector<std::string>{"2", "1 new"}));
}

TEST(ViewScene, WhoHasSeenSomeGetsTheRest) {
  ViewScene scene;
  scene.set_chunk(1, bytes("1"));
  scene.set_chunk(2, bytes("2"));
  const auto first = scene.next_after(0);
  ASSERT_TRUE(first);
  scene.set_chunk(1, bytes("1 new"));
  EXPECT_EQ(news_after(scene, first->serial), (std::vector<std::string>{"2", "1 new"}));
}

TEST(ViewScene, AClearedChunkIsSentAsGone) {
  ViewScene scene;
  scene.set_chunk(1, bytes("1"));
  scene.add_to_trail({0, 0, 0});
  scene.clear(5);
  const auto news = news_after(scene, 0);
  ASSERT_EQ(news.size(), 1u);
  EXPECT_EQ(news.front().size(), 16u);
  EXPECT_TRUE(scene.trail().empty());
}

TEST(ViewScene, AnotherTrailTakesThePlaceOfTheFirst) {
  ViewScene scene;
  for (int i = 0; i < 5'000; ++i) scene.add_to_trail({0, 0, 1});
  scene.set_trail({{1, 0, 0}, {2, 0, 0}, {3, 0, 0}});
  ASSERT_EQ(scene.trail().size(), 3u) << "none of them is left out";
  scene.add_to_trail({4, 0, 0});
  EXPECT_EQ(scene.trail().back().x(), 4);
}

TEST(ViewScene, TheTrailStaysShortAndKeepsItsBeginning) {
  ViewScene scene;
  constexpr int kPositions = 100'000;
  for (int i = 0; i < kPositions; ++i) scene.add_to_trail({static_cast<double>(i), 0, 0});
  ASSERT_LE(scene.trail().size(), 1'000u);
  ASSERT_GE(scene.trail().size(), 400u);
  EXPECT_EQ(scene.trail().front().x(), 0);
  EXPECT_GT(scene.trail().back().x(), 0.99 * kPositions);
  for (std::size_t i = 1; i < scene.trail().size(); ++i) EXPECT_GT(scene.trail()[i].x(), scene.trail()[i - 1].x());
}

}  // namespace
}  // namespace scanknit
