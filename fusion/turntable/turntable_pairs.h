// TurntablePairs: measures the motions between frames of a turntable by registration.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/noise_model.h"
#include "fusion/register/surface_pyramid.h"
#include "fusion/turntable/turntable_solver.h"

namespace scanknit {

class TurntablePairs {
 public:
  /// `start` has approximate angles of all frames. Keeps a key frame every few degrees, about a hundred at most.
  TurntablePairs(const TurntableMotion& start, const NoiseModel& noise);

  /// Adds frame number `frame` of the motion. Numbers must ascend; some may be missing. Registers the frame with the
  /// key frames before and after it, and a key frame with the three before it.
  void add(std::size_t frame, SurfacePyramid seen);

  /// To be called after the last frame: registers key frames at the same place of different turns with each other,
  /// which closes the turn.
  void close();

  /// Registers key frames that are an eighth to half a turn apart by `motion`, if they see the same surface. Only
  /// within each of the `parts` (one number for each frame), because the motion between parts is unknown.
  void join_across(const TurntableMotion& motion, const std::vector<std::size_t>& parts);

  [[nodiscard]] const std::vector<TurntableEdge>& edges() const { return edges_; }
  /// Removes pairs; one flag for each pair.
  void remove(const std::vector<bool>& is_removed);

  /// The share of key frames that fit the one before; 1 for a single key frame.
  [[nodiscard]] double share_in_sequence() const;
  [[nodiscard]] std::size_t key_frames() const { return keys_.size(); }
  [[nodiscard]] std::size_t loops() const { return loops_; }    ///< pairs found by close()
  [[nodiscard]] std::size_t across() const { return across_; }  ///< pairs found by join_across()

 private:
  struct View {
    std::size_t frame;
    SurfacePyramid seen;
  };
  [[nodiscard]] std::vector<double> nearby_angles(const View& from, const View& to) const;
  [[nodiscard]] double angle_between(const View& from, const View& to) const;
  bool join(const View& from, const View& to, const std::vector<double>& angles_rad, const TurntableAxis& axis,
            int first_level);
  void join_pending();

  TurntableMotion start_;
  NoiseModel noise_;
  double spacing_rad_, usual_step_rad_;
  std::vector<View> keys_;
  std::vector<View> pending_;  ///< frames since the last key frame
  std::vector<TurntableEdge> edges_;
  std::size_t loops_ = 0, across_ = 0;
  std::size_t in_sequence_ = 0;  ///< key frames that fit the one before
};

}  // namespace scanknit
