#include "view/view_scene.h"

#include <utility>

#include "view/mesh_chunk.h"

namespace scanknit {

void ViewScene::set_chunk(std::uint32_t chunk, ViewBytes message) {
  const auto known = serial_of_.find(chunk);
  if (known != serial_of_.end()) by_serial_.erase(known->second);
  serial_of_[chunk] = ++serial_;
  by_serial_[serial_] = {chunk, std::move(message)};
}

void ViewScene::clear(std::uint32_t revision) {
  std::vector<std::uint32_t> chunks;
  for (const auto& [chunk, serial] : serial_of_) chunks.push_back(chunk);
  for (const std::uint32_t chunk : chunks) {
    set_chunk(chunk, shared_text(chunk_gone_message(chunk, revision)));
  }
  set_trail({});
}

std::optional<ViewScene::Chunk> ViewScene::next_after(std::uint64_t serial) const {
  const auto next = by_serial_.upper_bound(serial);
  if (next == by_serial_.end()) return std::nullopt;
  return Chunk{next->first, next->second.message};
}

void ViewScene::set_trail(const std::vector<Eigen::Vector3d>& positions) {
  trail_.clear();
  trail_step_ = 1;
  trail_count_ = 0;
  for (const Eigen::Vector3d& position : positions) add_to_trail(position);
}

void ViewScene::add_to_trail(const Eigen::Vector3d& position) {
  constexpr std::size_t kMostPositions = 1'000;
  if (trail_count_++ % trail_step_ != 0) return;
  trail_.push_back(position);
  if (trail_.size() < kMostPositions) return;
  for (std::size_t i = 0; 2 * i < trail_.size(); ++i) trail_[i] = trail_[2 * i];  // removes every other position
  trail_.resize((trail_.size() + 1) / 2);
  trail_step_ *= 2;
}

}  // namespace scanknit
