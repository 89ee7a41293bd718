// ViewFeed: what one client of the live view is to be sent next.
#pragma once

#include <cstdint>
#include <deque>

#include "view/view_scene.h"

namespace scanknit {

/// Texts that were said come first and all; of everything else the newest, as far as there is credit.
class ViewFeed {
 public:
  /// `scene` outlives it. The first texts: hello, files, crop box and trail.
  explicit ViewFeed(const ViewScene& scene);

  /// False: so much waits already that the client seems not to read at all.
  [[nodiscard]] bool say(ViewBytes text);

  struct Next {
    ViewBytes message;  ///< null: nothing to be sent now
    bool is_text = true;
  };
  [[nodiscard]] Next next();

  /// The client has used so many binary messages.
  void give_credit(std::uint32_t messages);

  /// No text and no state waits.
  [[nodiscard]] bool has_told_all() const { return texts_.empty() && state_seen_ == scene_.state_serial; }

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
