// ViewFeed: decides what to send next to one client of the live view.
#pragma once

#include <cstdint>
#include <deque>

#include "view/view_scene.h"

namespace scanknit {

/// Queued texts come first, and all of them are sent. Of everything else, only the newest is sent, as far as there is
/// credit.
class ViewFeed {
 public:
  /// `scene` outlives it. The first texts: hello, files, crop box and trail.
  explicit ViewFeed(const ViewScene& scene);

  /// Queues a text. False: so many wait already that the client seems not to read.
  [[nodiscard]] bool queue_text(ViewBytes text);

  struct Next {
    ViewBytes message;  ///< null: nothing to send now
    bool is_text = true;
  };
  [[nodiscard]] Next next();

  /// The client has processed so many binary messages.
  void give_credit(std::uint32_t messages);

  /// True when no text and no state waits.
  [[nodiscard]] bool is_up_to_date() const { return texts_.empty() && state_seen_ == scene_.state_serial; }

 private:
  [[nodiscard]] ViewBytes next_text();
  [[nodiscard]] ViewBytes next_binary();

  const ViewScene& scene_;
  std::deque<ViewBytes> texts_;
  std::uint64_t state_seen_ = 0, pose_seen_ = 0, picture_seen_ = 0, chunk_seen_ = 0;
  std::uint32_t in_flight_ = 0;
  bool was_picture_ = false;
};

}  // namespace scanknit
