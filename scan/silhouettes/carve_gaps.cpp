#include "scan/silhouettes/carve_gaps.h"

#include <fmt/format.h>

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "acquire/filter/depth_filter.h"
#include "acquire/masks/found_masks.h"
#include "fusion/shutter/deskew.h"
#include "fusion/silhouette/fill_gaps.h"
#include "scan/frames/frames_again.h"
#include "scan/silhouettes/silhouette_views.h"

namespace scanknit {
namespace {

constexpr std::size_t kMostViews = 100;   // more hardly make the hull smaller
constexpr std::size_t kMostPainted = 36;  // of these
constexpr double kFirstReach_px = 16;     // enough to find the box; the band may ask for more

/// Every n-th frame's number, so that there are at most `most`.
std::vector<std::uint64_t> spread(const Trajectory& trajectory, std::size_t most) {
  const std::size_t every = (trajectory.size() + most - 1) / most;
  std::vector<std::uint64_t> sequences;
  for (std::size_t i = 0; i < trajectory.size(); i += every) sequences.push_back(trajectory[i].sequence);
  return sequences;
}

class GapCarver {
 public:
  GapCarver(const GapsToCarve& request, TsdfVolume& volume, ScanSession& session)
      : request_(request), volume_(volume), session_(session), frames_(request.archive, session.stop()) {
    for (const PosedFrame& frame : request.trajectory) posed_[frame.sequence] = &frame;
  }

  [[nodiscard]] Result<std::optional<SilhouetteResult>> run() {
    const std::optional<SilhouetteResult> as_it_was;
    if (auto read = read_masks(); !read) return read.error();
    if (session_.is_stopped()) return as_it_was;
    const auto box = session_.timed("carve", [&] { return hull_box(read_.views); });
    if (!box) return give_up(read_.views.size() < 2 && fault_ ? *fault_ : box.error().message), as_it_was;
    auto gaps = session_.timed("carve", [&] { return find_gaps(*box); });
    if (!gaps) return gaps.error();
    if (auto looked = look_through(*gaps); !looked) return looked.error();
    if (session_.is_stopped()) return as_it_was;
    if (auto filled = session_.timed("carve", [&] { return fill(*gaps); }); !filled) return filled.error();
    return std::optional(session_.timed("agreement", [&] { return agreement_of(read_, volume_, session_); }));
  }

 private:
  void give_up(const std::string& why) {
    session_.warn(WarningCode::kSilhouettes,
                  fmt::format("nothing is filled by silhouettes (fusion.silhouettes): {}", why));
  }

  [[nodiscard]] Result<void> read_masks() {
    const std::vector<std::uint64_t> chosen = spread(request_.trajectory, kMostViews);
    auto read = frames_.for_each_of(chosen, [&](Frame& frame) -> Result<Reading> {
      session_.progress("reading masks", ++read_.frames.read, chosen.size());
      add_view(frame);
      return Reading::kContinue;
    });
    if (read && read_.frames.dropped > 0 && read_.views.size() >= 2) {
      session_.warn(WarningCode::kSilhouettes, fmt::format("{} of {} masks are not used for fusion.silhouettes: {}",
                                                           read_.frames.dropped, read_.frames.read, *fault_));
    }
    return read;
  }

  void add_view(Frame& frame) {
    const auto sound = frame.labels.empty() ? Result<void>(Error{ErrorCode::kInput, "the frame has no mask"})
                                            : check_silhouette(frame.labels);
    if (!sound) {
      ++read_.frames.dropped;
      if (!fault_) fault_ = fmt::format("frame {}: {}", frame.sequence, sound.error().message);
      return;
    }
    const Pose& T_world_camera = posed_.at(frame.sequence)->T_world_camera;
    read_.views.push_back({frame.intrinsics, T_world_camera, Silhouette(frame.labels, kFirstReach_px)});
    read_.pictures.push_back({{}, std::move(frame.labels), frame.intrinsics});
    read_.names.push_back(fmt::format("frame {}", frame.sequence));
    read_.numbers.push_back(frame.sequence);
    const std::size_t every = (kMostViews + kMostPainted - 1) / kMostPainted;
    if (frame.colour && read_.views.size() % every == 1) {
      colour_poses_.push_back(T_world_camera * frame.colour->T_colour_depth.inverse());
      colours_.push_back(*std::move(frame.colour));
    }
  }

  [[nodiscard]] Result<DepthGaps> find_gaps(const Eigen::AlignedBox3d& box) {
    const double band_m = double{volume_.tsdf().background()};
    reach_band(box, band_m, read_);
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(band_m);
    return DepthGaps::find(read_.views, {box.min() - margin, box.max() + margin}, volume_, request_.may_fill);
  }

  /// All frames tell what is free.
  [[nodiscard]] Result<void> look_through(DepthGaps& gaps) {
    std::vector<std::uint64_t> all;
    for (const auto& [sequence, posed] : posed_) all.push_back(sequence);
    std::size_t looked = 0;
    return frames_.for_each_of(all, [&](Frame& frame) -> Result<Reading> {
      session_.progress("looking for gaps", ++looked, all.size());
      const PosedFrame& posed = *posed_.at(frame.sequence);
      const ScanConfig& config = request_.config;
      if (auto filtered = filter_frame(frame, config.acquire, config.fusion.noise); !filtered) return filtered.error();
      deskew(posed.motion, frame);
      session_.timed("carve", [&] { gaps.look_through(frame.depth_m, frame.intrinsics, posed.T_world_camera); });
      return Reading::kContinue;
    });
  }

  [[nodiscard]] Result<void> fill(const DepthGaps& gaps) {
    const bool was_full = volume_.is_budget_reached;
    const auto filled = fill_gaps(gaps, volume_);
    if (!filled) return filled.error();
    if (filled->is_budget_reached && !was_full) {
      session_.warn(WarningCode::kBudgetReached,
                    "the volume has reached fusion.memory_budget: silhouettes fill a part of what depth left");
    }
    session_.info(fmt::format("silhouettes of {} frames fill {} voxels that depth left", read_.views.size(),
                              filled->voxels_inside));
    std::vector<ColourOfView> views;
    for (std::size_t i = 0; i < colours_.size(); ++i) {
      views.push_back({&colours_[i].image, colours_[i].intrinsics, colour_poses_[i]});
    }
    if (!views.empty()) paint_filled(views, *filled, volume_);
    return {};
  }

  const GapsToCarve& request_;
  TsdfVolume& volume_;
  ScanSession& session_;
  FramesAgain frames_;
  std::map<std::uint64_t, const PosedFrame*> posed_;
  SilhouettePictures read_;
  std::optional<std::string> fault_;  ///< of the first mask that is not used
  std::vector<ColourFrame> colours_;
  std::vector<Pose> colour_poses_;
};

}  // namespace

Result<std::optional<SilhouetteResult>> carve_gaps(const GapsToCarve& request, TsdfVolume& volume,
                                                   ScanSession& session) {
  return GapCarver(request, volume, session).run();
}

}  // namespace scanknit
