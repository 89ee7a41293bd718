// TurntablePairs: what the frames of a turntable say of each other, measured by registration.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/noise_model.h"
#include "fusion/track/surface_pyramid.h"
#include "fusion/turntable/turntable_solver.h"

namespace scanknit {

class TurntablePairs {
 public:
  /// `start` says where each frame roughly is. Frames every few degrees are key frames and are kept, about a hundred at
  /// most.
  TurntablePairs(const TurntableMotion& start, const NoiseModel& noise);

  /// Frame number `frame` of the motion, in ascending order; some may be left out. Registered with the key frames
  /// before and after it; a key frame with three before it.
  void add(std::size_t frame, SurfacePyramid seen);

  /// After the last frame: key frames that come by the same place of the turn again are registered with each other,
  /// which closes it.
  void close();

  /// Key frames an eighth to half a turn apart, as far as they see the same, from where `motion` has them. Only within
  /// one of the `parts`, one number a frame: between them it does not know where they are.
  void join_across(const TurntableMotion& motion, const std::vector<std::size_t>& parts);

  [[nodiscard]] const std::vector<TurntableEdge>& edges() const { return edges_; }
  /// Takes back pairs, one flag each.
  void forget(const std::vector<bool>& is_forgotten);

  /// Share of the key frames that fit the one before; 1 of a single one.
  [[nodiscard]] double share_in_sequence() const;
  [[nodiscard]] std::size_t key_frames() const { return keys_.size(); }
  [[nodiscard]] std::size_t loops() const { return loops_; }    ///< pairs found by close()
  [[nodiscard]] std::size_t across() const { return across_; }  ///< and by join_across()

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
  std::vector<View> pending_;  ///< since the last key frame
  std::vector<TurntableEdge> edges_;
  std::size_t loops_ = 0, across_ = 0;
  std::size_t in_sequence_ = 0;  ///< key frames that fit the one before
};

}  // namespace scanknit
