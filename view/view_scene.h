// ViewScene: the newest version of everything that the live view's pages show.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "view/view_messages.h"

namespace scanknit {

/// A message, shared by all clients that receive it.
using ViewBytes = std::shared_ptr<const std::string>;
[[nodiscard]] inline ViewBytes shared_text(std::string text) {
  return std::make_shared<const std::string>(std::move(text));
}

/// For one thread. Every chunk that is set gets a higher serial number than all before. One number thus says which
/// changes a client has seen: it gets the oldest change first, and never an old revision.
class ViewScene {
 public:
  void set_chunk(std::uint32_t chunk, ViewBytes message);
  /// Replaces every chunk by its `gone` message.
  void clear(std::uint32_t revision);

  struct Chunk {
    std::uint64_t serial = 0;
    ViewBytes message;
  };
  /// The chunk with the lowest serial number after `serial`.
  [[nodiscard]] std::optional<Chunk> next_after(std::uint64_t serial) const;

  void add_to_trail(const Eigen::Vector3d& position);
  void set_trail(const std::vector<Eigen::Vector3d>& positions);
  [[nodiscard]] const std::vector<Eigen::Vector3d>& trail() const { return trail_; }

  ViewBytes hello, state, pose, files, crop, picture;  ///< null: not set yet
  std::uint64_t state_serial = 0, pose_serial = 0, picture_serial = 0;

 private:
  std::uint64_t serial_ = 0;
  std::map<std::uint32_t, std::uint64_t> serial_of_;  ///< serial number of each chunk
  struct Numbered {
    std::uint32_t chunk;
    ViewBytes message;
  };
  std::map<std::uint64_t, Numbered> by_serial_;
  std::vector<Eigen::Vector3d> trail_;
  std::size_t trail_step_ = 1;   ///< keeps every so many-th position
  std::size_t trail_count_ = 0;  ///< positions received
};

}  // namespace scanknit
