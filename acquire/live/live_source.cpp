#include "acquire/live/live_source.h"

#include <algorithm>
#include <string>
#include <utility>

#include "acquire/raw/raw_decode.h"
#include "acquire/sensor/recognise_sensor.h"
#include "acquire/sensor/scanner_camera.h"
#include "acquire/stereo/pair_depth.h"

namespace scanknit {
namespace {

using std::chrono::steady_clock;

constexpr std::size_t kQueueFrames = 32;  // half a second of two streams
constexpr auto kPatience = std::chrono::milliseconds(50);
constexpr auto kLossesEvery = std::chrono::seconds(1);

const StreamProfile* stream_of(const std::vector<StreamProfile>& streams, StreamKind kind) {
  const auto found = std::find_if(streams.begin(), streams.end(), [&](const auto& s) { return s.kind == kind; });
  return found == streams.end() ? nullptr : &*found;
}

RecordingInfo describe(const LiveScanner& scanner, const LiveOptions& options, const PairDepth* pairs) {
  RecordingInfo info;
  info.format = "live";
  info.frames = options.frames.value_or(0);
  info.poses = options.poses;
  info.intrinsics = scanner.calibration.depth.intrinsics;
  info.has_colour = stream_of(scanner.streams, StreamKind::kColour) != nullptr;
  if (info.has_colour) info.colour_intrinsics = scanner.calibration.colour.intrinsics;
  if (pairs == nullptr) {
    info.depth_scale = 1 / scanner.calibration.depth_unit_m;
    info.sensor = sensor_by_name({info.format, {}, scanner.calibration.device});
    return info;
  }
  info.sensor = pairs->sensor();
  if (!info.has_colour) info.colour_intrinsics = info.intrinsics;  // the left picture
  info.has_colour = true;
  return info;
}

FrameDropped drop(std::uint64_t sequence, DropReason reason, std::string message) {
  return {sequence, reason, {ErrorCode::kInput, std::move(message)}};
}

}  // namespace

Result<std::unique_ptr<LiveSource>> LiveSource::start(LiveScanner scanner, LiveOptions options, Recorder* recorder) {
  const std::vector<StreamProfile> streams = scanner.streams;
  if (options.camera) {
    if (auto done = override_calibration(*options.camera, streams, scanner.calibration); !done) return done.error();
  }
  std::unique_ptr<PairDepth> pairs;
  const StreamProfile* depth = stream_of(streams, StreamKind::kDepth);
  if (depth != nullptr && depth->format == PixelFormat::kY8i && options.matches_pairs) {
    auto created = PairDepth::create(scanner.calibration, options.min_depth_m);
    if (!created) return created.error();
    pairs = *std::move(created);
  }
  std::unique_ptr<LiveSource> source(
      new LiveSource(std::move(scanner), std::move(options), recorder, std::move(pairs)));
  const auto started = source->device_->start(
      streams, [self = source.get()](RawFrame frame) { self->take(std::move(frame)); },
      [self = source.get()](const DeviceEvent& event) {
        const std::scoped_lock lock(self->events_mutex_);
        self->events_.push_back(event);
      });
  if (!started) return started.error();
  return source;
}

LiveSource::LiveSource(LiveScanner scanner, LiveOptions options, Recorder* recorder, std::unique_ptr<PairDepth> pairs)
    : has_colour_stream_(stream_of(scanner.streams, StreamKind::kColour) != nullptr),
      pairs_(std::move(pairs)),
      info_(describe(scanner, options, pairs_.get())),
      options_(std::move(options)),
      recorder_(recorder),
      calibration_(std::move(scanner.calibration)),
      queue_(kQueueFrames),
      pairing_(has_colour_stream_),
      device_(std::move(scanner.device)) {}

LiveSource::~LiveSource() {
  device_->stop();
}

void LiveSource::take(RawFrame frame) {
  // A recording of so many pictures has no more, although some come before the scanner has stopped.
  const bool is_depth = frame.profile.kind == StreamKind::kDepth;
  const bool is_one_too_many = is_depth && options_.frames && depth_taken_++ >= *options_.frames;
  if (recorder_ != nullptr && !is_one_too_many) recorder_->record(frame);
  if (!queue_.try_push(std::move(frame))) ++lost_in_queue_;
}

LossCounters LiveSource::losses() const {
  LossCounters losses = device_->losses();
  losses.queue += lost_in_queue_;
  return losses;
}

void LiveSource::report_events() {
  std::vector<DeviceEvent> events;
  {
    const std::scoped_lock lock(events_mutex_);
    events.swap(events_);
  }
  for (const DeviceEvent& event : events) {
    if (options_.on_event) options_.on_event(event);
    if (event.kind == DeviceEvent::Kind::kNoColour) pairing_.expect_colour(false);
    if (event.kind == DeviceEvent::Kind::kReturned) pairing_.expect_colour(has_colour_stream_);
    const bool is_gone = event.kind == DeviceEvent::Kind::kLeft && !options_.survives_unplugging;
    if (event.kind == DeviceEvent::Kind::kFailed || is_gone) failure_ = Error{ErrorCode::kDevice, event.text};
  }
}

void LiveSource::report_losses() {
  const auto now = steady_clock::now();
  if (recorder_ == nullptr || now - losses_at_ < kLossesEvery) return;
  losses_at_ = now;
  recorder_->note_losses(losses());
}

void LiveSource::report_recorder_failure() {
  if (recorder_ == nullptr || has_reported_recorder_failure_ || !options_.on_recorder_failure) return;
  const auto failure = recorder_->failure();
  if (!failure) return;
  has_reported_recorder_failure_ = true;
  options_.on_recorder_failure(*failure);
}

bool LiveSource::is_over() const {
  if (options_.frames && pictures_ >= *options_.frames) return true;
  const auto seconds_past = [&] { return std::chrono::duration<double>(steady_clock::now() - *first_at_).count(); };
  return options_.seconds && first_at_ && seconds_past() >= *options_.seconds;
}

std::optional<RawPair> LiveSource::newest_pair() {
  std::optional<RawPair> newest;
  const auto keep = [&](RawPair pair) {
    if (newest) skipped_.push_back(drop(newest->depth.sequence, DropReason::kQueue, "a newer frame was there already"));
    newest = std::move(pair);
    ++pictures_;
  };
  auto patience = std::chrono::nanoseconds(kPatience);
  while (auto frame = queue_.pop(std::stop_token{}, patience)) {
    pairing_.add(*std::move(frame));
    while (!is_over()) {
      auto pair = pairing_.next();
      if (!pair) break;
      keep(*std::move(pair));
    }
    patience = std::chrono::nanoseconds::zero();
  }
  if (newest && !first_at_) first_at_ = steady_clock::now();
  return newest;
}

FrameEvent LiveSource::decode(const RawPair& pair) {
  auto frame = decode_raw_frame(pair.depth, pair.colour ? &*pair.colour : nullptr, calibration_, limits_, pairs_.get());
  if (!frame) return FrameDropped{pair.depth.sequence, DropReason::kUnreadable, frame.error()};
  if (last_timestamp_ns_ && frame->timestamp_ns <= *last_timestamp_ns_) {
    return drop(pair.depth.sequence, DropReason::kTimestamp, "its time is not after that of the frame before");
  }
  last_timestamp_ns_ = frame->timestamp_ns;
  if (options_.camera && options_.camera->depth_bias) {
    if (!correction_) {
      correction_.emplace(*options_.camera->depth_bias, frame->depth_m.width(), frame->depth_m.height());
    }
    correction_->apply(frame->depth_m);
  }
  if (info_.poses == PoseMode::kStill) frame->T_world_camera = Pose::Identity();
  return *std::move(frame);
}

bool LiveSource::has_ended(const std::stop_token& stop) const {
  return stop.stop_requested() || is_over() || failure_;
}

bool LiveSource::wait(std::stop_token stop, std::chrono::milliseconds patience) {
  const auto deadline = steady_clock::now() + patience;
  while (true) {
    report_events();
    report_losses();
    report_recorder_failure();
    if (ready_ || !skipped_.empty() || has_ended(stop)) return true;
    ready_ = newest_pair();
    if (!ready_ && steady_clock::now() >= deadline) return false;
  }
}

FrameEvent LiveSource::next(std::stop_token stop) {
  while (!wait(stop, kPatience)) {
  }
  if (ready_) {
    const RawPair pair = *std::move(ready_);
    ready_.reset();
    return decode(pair);
  }
  if (!skipped_.empty()) {
    FrameDropped first = std::move(skipped_.front());
    skipped_.pop_front();
    return first;
  }
  device_->stop();
  return EndOfStream{};
}

}  // namespace scanknit
