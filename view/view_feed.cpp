#include "view/view_feed.h"

#include <algorithm>
#include <utility>

namespace scanknit {
namespace {

constexpr std::size_t kMostTextsWaiting = 256;
// So many messages in flight let a page that draws slowly still receive a few chunks for each picture that it draws.
constexpr std::uint32_t kBinaryInFlight = 8;

}  // namespace

ViewFeed::ViewFeed(const ViewScene& scene) : scene_(scene) {
  for (const ViewBytes& text : {scene.hello, scene.files, scene.crop}) {
    if (text != nullptr) texts_.push_back(text);
  }
  texts_.push_back(shared_text(trail_message(scene.trail())));
}

bool ViewFeed::queue_text(ViewBytes text) {
  if (texts_.size() >= kMostTextsWaiting) return false;
  texts_.push_back(std::move(text));
  return true;
}

ViewFeed::Next ViewFeed::next() {
  if (ViewBytes text = next_text()) return {std::move(text), /*is_text=*/true};
  return {next_binary(), /*is_text=*/false};
}

void ViewFeed::give_credit(std::uint32_t messages) {
  in_flight_ -= std::min(in_flight_, messages);
}

ViewBytes ViewFeed::next_text() {
  if (!texts_.empty()) {
    ViewBytes text = std::move(texts_.front());
    texts_.pop_front();
    return text;
  }
  if (state_seen_ != scene_.state_serial) {
    state_seen_ = scene_.state_serial;
    return scene_.state;
  }
  if (pose_seen_ != scene_.pose_serial) {
    pose_seen_ = scene_.pose_serial;
    return scene_.pose;
  }
  return nullptr;
}

/// The next picture or chunk, in turn.
ViewBytes ViewFeed::next_binary() {
  if (in_flight_ >= kBinaryInFlight) return nullptr;
  const bool has_picture = picture_seen_ != scene_.picture_serial;
  const auto chunk = scene_.next_after(chunk_seen_);
  if (!has_picture && !chunk) return nullptr;
  ++in_flight_;
  if (has_picture && (!chunk || !was_picture_)) {
    was_picture_ = true;
    picture_seen_ = scene_.picture_serial;
    return scene_.picture;
  }
  was_picture_ = false;
  chunk_seen_ = chunk->serial;
  return chunk->message;
}

}  // namespace scanknit
