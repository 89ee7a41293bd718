#include "acquire/convert/sharpest_frames.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>
#include <variant>

namespace scanknit {
namespace {

/// A frame that may be chosen.
struct Candidate {
  std::size_t position = 0;         // among all frames
  double way = 0;                   // of the camera from the first candidate on, metres and radians
  std::optional<double> sharpness;  // nothing: no colour
};

double way_between(const Pose& from, const Pose& to) {
  const Pose step = from.inverse() * to;
  return step.translation().norm() + Eigen::AngleAxisd(step.linear()).angle();
}

/// Notes all frames of a recording, without their pictures.
class CandidateList {
 public:
  void add(const Frame& frame) {
    const std::size_t position = frames_++;
    if (!frame.T_world_camera) return;
    if (last_) way_ += way_between(*last_, *frame.T_world_camera);
    last_ = frame.T_world_camera;
    const auto sharp = frame.colour ? std::optional(sharpness(frame.colour->image)) : std::nullopt;
    candidates_.push_back({position, way_, sharp});
  }

  [[nodiscard]] std::vector<std::size_t> sharpest(std::size_t count) {
    const auto has_colour = [](const Candidate& candidate) { return candidate.sharpness.has_value(); };
    if (std::any_of(candidates_.begin(), candidates_.end(), has_colour)) {
      candidates_.erase(std::remove_if(candidates_.begin(), candidates_.end(), std::not_fn(has_colour)),
                        candidates_.end());
    }
    std::vector<const Candidate*> best(count, nullptr);
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      const Candidate*& of_part = best[part_of(i, count)];
      if (of_part == nullptr || candidates_[i].sharpness > of_part->sharpness) of_part = &candidates_[i];
    }
    std::vector<std::size_t> positions;
    for (const Candidate* candidate : best) {
      if (candidate != nullptr) positions.push_back(candidate->position);
    }
    return positions;
  }

  [[nodiscard]] bool is_empty() const { return candidates_.empty(); }

 private:
  [[nodiscard]] std::size_t part_of(std::size_t i, std::size_t count) const {
    constexpr double kStandsStill = 1e-9;
    const double begin = candidates_.front().way, whole = candidates_.back().way - begin;
    const double share = whole > kStandsStill ? (candidates_[i].way - begin) / whole
                                              : static_cast<double>(i) / static_cast<double>(candidates_.size());
    return std::min(count - 1, static_cast<std::size_t>(share * static_cast<double>(count)));
  }

  std::vector<Candidate> candidates_;
  std::size_t frames_ = 0;
  double way_ = 0;
  std::optional<Pose> last_;
};

class ChosenFrames final : public FrameSource {
 public:
  ChosenFrames(std::unique_ptr<FrameSource> source, std::vector<std::size_t> chosen)
      : source_(std::move(source)), chosen_(std::move(chosen)) {}

  [[nodiscard]] const RecordingInfo& info() const override { return source_->info(); }
  [[nodiscard]] FrameEvent next(std::stop_token stop) override {
    for (;;) {
      if (next_ == chosen_.size()) return EndOfStream{};
      FrameEvent event = source_->next(stop);
      if (!std::holds_alternative<Frame>(event)) return event;
      if (position_++ != chosen_[next_]) continue;
      ++next_;
      return event;
    }
  }

 private:
  std::unique_ptr<FrameSource> source_;
  std::vector<std::size_t> chosen_;
  std::size_t next_ = 0, position_ = 0;
};

}  // namespace

double sharpness(const ColourImage& picture) {
  const int width = picture.width(), height = picture.height();
  if (width < 3 || height < 3) return 0;
  Image<int> grey(width, height);
  std::transform(picture.pixels().begin(), picture.pixels().end(), grey.pixels().begin(), [](const Rgb8& pixel) {
    return (299 * pixel.r + 587 * pixel.g + 114 * pixel.b + 500) / 1000;  // BT.601
  });
  double sum = 0, squares = 0;
  for (int y = 1; y + 1 < height; ++y) {
    for (int x = 1; x + 1 < width; ++x) {
      const int laplacian =
          grey.at(x - 1, y) + grey.at(x + 1, y) + grey.at(x, y - 1) + grey.at(x, y + 1) - 4 * grey.at(x, y);
      sum += laplacian;
      squares += static_cast<double>(laplacian) * laplacian;
    }
  }
  const double n = static_cast<double>(width - 2) * (height - 2);
  return squares / n - (sum / n) * (sum / n);
}

Result<std::vector<std::size_t>> find_sharpest_frames(FrameSource& source, std::size_t count,
                                                      const ConvertProgress& progress, std::stop_token stop) {
  CandidateList candidates;
  for (std::size_t done = 0;;) {
    const FrameEvent event = source.next(stop);
    if (std::holds_alternative<EndOfStream>(event)) break;
    if (const auto* error = std::get_if<Error>(&event)) return *error;
    if (const auto* frame = std::get_if<Frame>(&event)) candidates.add(*frame);
    if (progress) progress(++done);
  }
  if (candidates.is_empty()) {
    return Error{ErrorCode::kInput,
                 "no frame has a pose, by which frames are chosen; convert a recording that has poses",
                 source.info().folder.string()};
  }
  return candidates.sharpest(count);
}

std::unique_ptr<FrameSource> only_frames(std::unique_ptr<FrameSource> source, std::vector<std::size_t> chosen) {
  return std::make_unique<ChosenFrames>(std::move(source), std::move(chosen));
}

}  // namespace scanknit
